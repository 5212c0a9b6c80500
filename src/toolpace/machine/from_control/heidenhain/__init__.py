"""Heidenhain: machine parameters and kinematics tables of the iTNC, configuration objects of the TNC 640."""
