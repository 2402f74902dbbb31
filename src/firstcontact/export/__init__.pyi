"""Trained models in other languages: a C99 library, ONNX, images for the hand."""

from ._export_model import export_model as export_model
from .registry import MODEL_EXPORTERS as MODEL_EXPORTERS
