"""Trained models in other languages: a C99 library, ONNX, images for the hand."""

from ._budget import forms as forms
from ._budget import instructions as instructions
from ._budget import microseconds as microseconds
from ._budget import small_enough as small_enough
from ._c_code import c_array as c_array
from ._c_code import literal as literal
from ._export_model import export_model as export_model
from ._hand_image import HandImage as HandImage
from ._hand_image import hand_image as hand_image
from ._parts import MODEL_EXPORTERS as MODEL_EXPORTERS
from ._parts import ModelExporter as ModelExporter
from ._parts import NamedModel as NamedModel
from ._parts import Trained as Trained
