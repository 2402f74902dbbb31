"""Trained models in other languages: C99 with its kernels, ONNX, images for the hand."""

from ._budget import forms as forms
from ._budget import microseconds as microseconds
from ._budget import small_enough as small_enough
from ._c_library import fixed_sources as fixed_sources
from ._c_text import c_array as c_array
from ._c_text import literal as literal
from ._export_model import export_model as export_model
from ._exporters import MODEL_EXPORTERS as MODEL_EXPORTERS
from ._exporters import ModelExporter as ModelExporter
from ._hand_image import HandImage as HandImage
from ._hand_image import hand_image as hand_image
from ._trained import NamedModel as NamedModel
from ._trained import Trained as Trained
