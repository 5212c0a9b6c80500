"""Kernels of joint chains: forward and inverse kinematics, derivatives, branches."""
