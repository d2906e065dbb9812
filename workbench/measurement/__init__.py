"""Measurements for one purpose: what the robot is told, and what the answer says."""
