"""Results records from the few fields that a test needs."""

import types
from dataclasses import asdict
from typing import Any, get_args, get_origin, get_type_hints

import msgspec

from firstcontact.core import Record
from firstcontact.core.records import ByName, decode_by_name
from firstcontact_lab.report.page import State
from firstcontact_lab.report.results import SubjectResults, subject_kind
from firstcontact_lab.study.page import study_page
from firstcontact_lab.study.part import StudySettings
from firstcontact_lab.study.parts import PARTS


def results(**fields: Any) -> SubjectResults:
    """Return a subject's results. Missing fields of a record are zero or empty."""
    kind = study_subject()
    return msgspec.convert(filled(kind, fields), kind, dec_hook=decode_by_name)


def study_state(settings: StudySettings | None = None, **changes: Any) -> State:
    """Return the state of a study that has not begun."""
    fields = {
        "command": "firstcontact study",
        "settings": asdict(settings or StudySettings()),
        "options": {},
        "parts": PARTS,
        "page": study_page,
    }
    return State(**{**fields, **changes})


def study_subject() -> type[SubjectResults]:
    """Return the record type of a subject's results, with the fields of all parts."""
    list(PARTS.values())
    return subject_kind()


def filled(kind: Any, tree: Any) -> Any:
    """Return a tree with all required fields of a type."""
    origin, args = get_origin(kind), get_args(kind)
    if origin is types.UnionType:
        return filled(args[0], tree)
    if origin is ByName:
        each, about = args
        own_values = set(about.__struct_fields__)
        fields = filled(about, {k: v for k, v in tree.items() if k in own_values})
        return {k: filled(each, v) for k, v in tree.items() if k not in own_values} | fields
    if origin is dict and isinstance(tree, dict):
        return {name: filled(args[1], entry) for name, entry in tree.items()}
    if not (isinstance(kind, type) and issubclass(kind, Record)):
        return tree
    types_by_name = get_type_hints(kind)
    declared = msgspec.structs.fields(kind)
    hints = {f.encode_name: types_by_name[f.name] for f in declared}
    absent = [f.encode_name for f in declared if f.required and f.encode_name not in tree]
    return {name: filled(hints[name], entry) for name, entry in tree.items()} | {
        name: _nothing(hints[name]) for name in absent
    }


def _nothing(kind: Any) -> Any:
    kind = get_origin(kind) or kind
    return filled(kind, {}) if issubclass(kind, Record) else kind()
