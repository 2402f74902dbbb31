"""Shell completion of verbs, options and their choices, for bash and zsh."""

from __future__ import annotations

from firstcontact.cli.options import verb_arguments
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
    """Return the completion script. This call imports all verbs; the script runs without Python."""
    choices, options = [], []
    for verb in verb_places():
        named = [argument for argument in verb_arguments(configuration(verb)) if argument.flag]
        names = ["--help", "--help-all", "--verbose", *(argument.flag for argument in named)]
        choices += [
            f'        "{verb} {argument.flag}") words="{" ".join(argument.choices)}" ;;'
            for argument in named
            if argument.choices
        ]
        options.append(f'            "{verb} -"*) words="{" ".join(names)}" ;;')
    return _SCRIPT.format(
        first=" ".join([*verb_places(), *GENERAL]),
        choices="\n".join(choices),
        options="\n".join(options),
    )
