"""Trained models in other languages: C for the hand's microcontroller, ONNX for other programs."""
