"""Five-axis machines: machine file, kinematics, limits, reach."""
