"""Conformance checks for registered classes of all kinds, as functions with plain asserts."""

from ._anytime import check_anytime as check_anytime
from ._detector import check_detector as check_detector
from ._estimator import check_estimator as check_estimator
from ._hand import check_hand as check_hand
from ._policy import check_policy as check_policy
from ._policy import make_estimate as make_estimate
from ._source import check_source as check_source
from .synthetic import closings as closings
