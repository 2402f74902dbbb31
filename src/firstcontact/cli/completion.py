"""Shell completion of verbs, options and their choices, for bash and zsh."""

from __future__ import annotations

from dataclasses import fields
from typing import Annotated, Any, Literal, get_args, get_origin, get_type_hints

import tyro

from firstcontact.cli.verbs import GENERAL, configuration, verb_places

_SCRIPT = """\
# Completion of firstcontact for bash and zsh.
# bash: write it to ~/.local/share/bash-completion/completions/firstcontact
# zsh:  write it to a file, and source that file in ~/.zshrc after compinit
[ -z "${{ZSH_VERSION-}}" ] || {{ autoload -U +X bashcompinit && bashcompinit; }}
_firstcontact() {{
    local word="${{COMP_WORDS[COMP_CWORD]}}" words=
    if [ "$COMP_CWORD" -eq 1 ]; then
        words="{first}"
    else
        case "${{COMP_WORDS[1]}} ${{COMP_WORDS[COMP_CWORD - 1]}}" in
{choices}
        *)
            case "${{COMP_WORDS[1]}} $word" in
{options}
            esac ;;
        esac
    fi
    COMPREPLY=($(compgen -W "$words" -- "$word"))
}}
complete -o default -F _firstcontact firstcontact
"""


def completion_script() -> str:
    """Return the script. It imports the module of each verb, and runs without Python."""
    choices, options = [], []
    for verb in verb_places():
        names = ["--help", "--verbose"]
        for option, values in _options(configuration(verb)).items():
            names.append(option)
            if values:
                choices.append(f'        "{verb} {option}") words="{" ".join(values)}" ;;')
        options.append(f'            "{verb} -"*) words="{" ".join(names)}" ;;')
    return _SCRIPT.format(
        first=" ".join([*verb_places(), *GENERAL]),
        choices="\n".join(choices),
        options="\n".join(options),
    )


def _options(verb: type[Any]) -> dict[str, tuple[str, ...]]:
    """Return the options of a verb, each with its choices where it has some."""
    hints = get_type_hints(verb, include_extras=True)
    options: dict[str, tuple[str, ...]] = {}
    for field in fields(verb):
        hint, *extras = (
            get_args(hints[field.name])
            if get_origin(hints[field.name]) is Annotated
            else [hints[field.name]]
        )
        if tyro.conf.Positional in extras:
            continue
        name = field.name.replace("_", "-")
        options[f"--{name}"] = _choices(hint, extras)
        if hint is bool:
            options[f"--no-{name}"] = ()
    return options


def _choices(hint: Any, extras: list[Any]) -> tuple[str, ...]:
    for kind in (hint, *get_args(hint)):
        if get_origin(kind) is Literal:
            return get_args(kind)
    # A registry's names, as one_of writes them: {svm,cnn}
    names = [m.strip("{}") for e in extras if (m := getattr(e, "metavar", None) or "")[:1] == "{"]
    return tuple(names[0].split(",")) if names else ()
