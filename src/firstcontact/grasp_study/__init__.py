"""The grasp study: policies against one another on the twin, and its report."""
