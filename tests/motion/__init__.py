"""Tests of joint motion over time, and of what it uses."""
