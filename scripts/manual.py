#!/usr/bin/env python3
"""Other forms of the manual, made from `talus -help=json`.

    manual.py build/talus schema > talus.schema.json     JSON schema (draft 7) of scenes in YAML
    manual.py build/talus man > talus.1                  page for man(1)
    manual.py build/talus bash > talus                   completion for bash
    manual.py build/talus zsh > _talus                   completion for zsh

An editor with yaml-language-server takes the schema by a first line in the scene:

    # yaml-language-server: $schema=/usr/local/share/talus/talus.schema.json
"""
import datetime
import json
import os
import re
import subprocess
import sys

NAME = r"[A-Za-z0-9_]+"
REGIONS = ("body", "bc", "load", "track", "motion", "surface", "boundary", "profile", "section", "forest")
NUMBERS = r"^\s*[-+0-9.eE]+(\s*,\s*[-+0-9.eE]+)*\s*$"
PETSC = "options that stand beside `mpm` are PETSc's, as -snes_rtol"


def read(program):
    """The options of the program: a list of dicts; names without `mpm_`."""
    text = subprocess.run([program, "-help=json"], check=True, capture_output=True, text=True).stdout
    options = json.loads(text)
    for option in options:
        option["path"] = option["option"].removeprefix("mpm_")
    return options


# ---- schema ----

def number(option):
    """Schema of one number, or of several in a text with commas: how many may depend on others."""
    bounds = {key: option[key] for key in ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum") if key in option}
    kind = {"type": "integer" if option["type"] == "integer" else "number", **bounds}
    return {"anyOf": [kind, {"type": "string", "pattern": NUMBERS}, {"type": "array", "items": kind}]}


def words(option):
    """Schema of one word out of a few; YAML reads some of them as booleans or numbers."""
    choices = list(option["choices"])
    if choices == ["NAME"]:  # of a block
        return {"type": ["string", "number"]}
    if {"on", "yes", "true"} & set(choices):
        choices += [True, False]
    return {"enum": choices + [int(word) for word in option["choices"] if word.isdigit()]}


def value(option):
    """Schema of an option's value, with its line of the manual."""
    text = {"type": ["string", "number", "boolean", "null"]}
    if option["type"] in ("number", "integer"):
        schema = number(option)
    elif option["type"] == "word":
        schema = words(option)
    elif option["type"] == "boolean":
        schema = {"enum": [True, False, 0, 1, "true", "false", "yes", "no", "on", "off", "0", "1"]}
    else:
        schema = {"anyOf": [text, {"type": "array", "items": text}]}
    unit = f" ({option['unit']})" if option["unit"] else ""
    default = f"; default {option['default']}" if option["default"] else ""
    return {**schema, "description": f"{option['help']}{unit}{default}"}


def widen(option):
    """A material's number may vary by height or come from a file, and some others are maps."""
    schema = value(option)
    if option["type"] == "number" and (option["path"].startswith("material_NAME_") or "or a map of it" in option["help"]):
        return {"anyOf": [schema, {"type": "string"}], "description": schema["description"]}
    return schema


class Node:
    """Options below one key: `leaves` by the rest of their names, and the `blocks` that these may be grouped in."""

    def __init__(self):
        self.leaves = {}

    def add(self, rest, schema):
        """Another option; of two of one name both are right."""
        old = self.leaves.get(rest)
        if old and old != schema:
            known = old["anyOf"] if "description" not in old else [old]
            schema = {"anyOf": known + ([schema] if schema not in known else [])}
        self.leaves[rest] = schema

    def schema(self):
        """An object with every option by its whole name, and by groups of what its first words have in common."""
        properties = dict(self.leaves)
        groups = {}
        for rest, leaf in self.leaves.items():
            parts = rest.split("_")
            for k in range(1, len(parts)):
                groups.setdefault("_".join(parts[:k]), Node()).add("_".join(parts[k:]), leaf)
        for head, group in groups.items():
            inner = group.schema()
            properties[head] = {"anyOf": [properties[head], inner]} if head in properties else inner
        return {"type": "object", "properties": properties, "additionalProperties": False}


def laws(options):
    """The block of a material by its type."""
    common, types = [], {}
    for option in options:
        if not option["path"].startswith("material_NAME_"):
            continue
        found = re.match(r"Material of type (\w+):", option["section"])
        (types.setdefault(found[1], []) if found else common).append(option)
    cases = []
    for name, own in types.items():
        node = Node()
        for option in common + own:
            node.add(option["path"].removeprefix("material_NAME_"), widen(option))
        block = node.schema()
        block["properties"]["type"] = {"const": name}
        cases.append({"if": {"properties": {"type": {"const": name}}, "required": ["type"]}, "then": block})
    other = {"if": {"properties": {"type": {"enum": list(types)}}, "required": ["type"]}, "then": True,
             "else": {"not": {"required": ["type"]}, "description": f"type: one of {', '.join(types)}, or a plugin's law"}}
    return {"type": "object", "allOf": cases + [other]}


def kinds(options):
    """Named blocks by kind: {"body": schema of body_NAME}."""
    found = {}
    for option in options:
        match = re.match(r"([a-z]+)_NAME_(.+)", option["path"])
        if match:
            found.setdefault(match[1], Node()).add(match[2], widen(option))
        elif option["path"].startswith("BLOCK_"):
            for kind in REGIONS:
                found.setdefault(kind, Node()).add(option["path"].removeprefix("BLOCK_"), value(option))
    blocks = {kind: node.schema() for kind, node in found.items()}
    blocks["material"] = laws(options)
    return blocks


def schema(options):
    """JSON schema of a scene in YAML."""
    top = Node()
    for option in options:
        if "NAME" not in option["path"] and "BLOCK" not in option["path"]:
            top.add(option["path"], widen(option))
    scene = top.schema()
    flat = {"type": ["string", "number", "boolean", "null", "array"]}  # an option of the block by its whole name
    scene["patternProperties"] = {f"^{kind}_{NAME}$": {"anyOf": [block, flat]} for kind, block in kinds(options).items()}
    for key in list(scene["properties"]):  # a name of the scene's own, as point_material, is no block
        for pattern in scene["patternProperties"]:
            if re.match(pattern, key):
                pattern_of_others = pattern[1:-1].replace(NAME, f"(?!{key.split('_', 1)[1]}$){NAME}")
                scene["patternProperties"][f"^{pattern_of_others}$"] = scene["patternProperties"].pop(pattern)
                break
    return {"$schema": "http://json-schema.org/draft-07/schema#", "title": "Scene of Talus", "type": "object",
            "required": ["mpm"], "properties": {"mpm": scene}, "description": PETSC}


# ---- man page ----

def escape(text):
    """Text of roff."""
    text = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return "\\&" + text if text.startswith(".") else text


def man(options):
    """The page of section 1."""
    lines = [f".TH TALUS 1 {day()}", ".SH NAME", "talus \\- implicit material point method for soils, rocks, snow and structures",
             ".SH SYNOPSIS", ".B talus", "SCENE.yaml [MORE.yaml ...] [\\-option value ...]", ".br", ".B talus help",
             "[TOPIC | \\-mpm_option]", ".br", ".B talus check", "SCENE.yaml [\\-\\-picture FILE.png]", ".br",
             ".B talus check\\-law", "PLUGIN.so NAME", ".br", ".B talus plot",
             "PREFIX [\\-\\-help]", ".br", ".B talus view", "PREFIX", ".br", ".B mpiexec \\-n 4 talus", "SCENE.yaml [\\-option value ...]", ".SH DESCRIPTION",
             "A scene is a file in YAML. Each of its entries is an option, too:", ".B mpm: grid: cells: \\(dq60,60\\(dq", "is",
             ".BR \\-mpm_grid_cells .", "What comes later on the command line overrides what came before.",
             "NAME stands for the name of a block, BLOCK for its kind and name.", ".SH EXIT STATUS",
             "0: completed. 2: the scene is wrong, nothing was written. 3: gave up, the results so far are there.",
             "4: a file could not be written.", ".SH OPTIONS"]
    section = None
    for option in sorted(options, key=lambda item: order(options, item)):
        if option["section"] != section:
            section = option["section"]
            lines.append(f'.SS "{escape(section)}"')
        accepts = f"; one of {', '.join(option['choices'])}" if "choices" in option else ""
        unit = f"; {option['unit']}" if option["unit"] else ""
        default = "required" if option["required"] else f"default {option['default']}" if option["default"] else "optional"
        lines += [".TP", f".B \\-{escape(option['option'])}", escape(f"{option['help']} ({default}{unit}{accepts})")]
    lines += [".SH SEE ALSO", ".BR mpiexec (1)"]
    return "\n".join(lines) + "\n"


def day():
    """Today, or the day that the environment asks for to make the page again."""
    since = os.environ.get("SOURCE_DATE_EPOCH")
    return datetime.date.fromtimestamp(int(since)) if since else datetime.date.today()


def order(options, item):
    """Place of an option's section among the sections."""
    sections = list(dict.fromkeys(option["section"] for option in options))
    return sections.index(item["section"])


# ---- completion ----

def plain(options):
    """Options without a name in them, with the start of those that have one."""
    found = {"-" + re.split("NAME|BLOCK", option["option"])[0] for option in options}
    return sorted(found | {"-help", "-help=json", "--help", "--version", "-snes_monitor", "-ksp_monitor", "-log_view", "-options_file"})


def choices(options):
    """Words of options that have a choice."""
    return {"-" + option["option"]: option["choices"] for option in options if "choices" in option and "NAME" not in option["option"]}


def topics(options):
    """Topics of `talus help`."""
    found = []
    for section in dict.fromkeys(option["section"] for option in options):
        law = re.match(r"Material of type (\w+)", section)
        found.append(law[1] if law else re.split(r"[ ,;]", section)[0].lower())
    return sorted(set(found))


def bash(options):
    """Completion of options, their words, scenes, topics."""
    cases = "\n".join(f"    {name}) COMPREPLY=($(compgen -W '{' '.join(words)}' -- \"$word\")); return ;;" for name, words in sorted(choices(options).items()))
    return f"""# bash completion for talus
_talus() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}}
  COMPREPLY=()
  if [[ ${{COMP_WORDS[1]}} == help && $word != -* ]]; then
    COMPREPLY=($(compgen -W '{' '.join(topics(options))}' -- "$word"))
    return
  fi
  case $before in
{cases}
  esac
  if [[ $word == -* ]]; then
    compopt -o nospace 2>/dev/null
    COMPREPLY=($(compgen -W '{' '.join(plain(options))}' -- "$word"))
    [[ ${{#COMPREPLY[@]}} -eq 1 && ${{COMPREPLY[0]}} != *_ ]] && compopt +o nospace 2>/dev/null
    return
  fi
  ((COMP_CWORD == 1)) && COMPREPLY=($(compgen -W 'help check check-law plot view' -- "$word"))
  COMPREPLY+=($(compgen -f -X '!*.@(yaml|yml|opts|h5|csv)' -- "$word") $(compgen -d -- "$word"))
}}
shopt -s extglob
complete -o filenames -F _talus talus
"""


def zsh(options):
    """Completion of options, their words, scenes, topics."""
    cases = "\n".join(f"  {name}) compadd -- {' '.join(words)}; return ;;" for name, words in sorted(choices(options).items()))
    return f"""#compdef talus
local before=$words[CURRENT-1]
if [[ $words[2] == help && $CURRENT -gt 2 ]]; then
  compadd -- {' '.join(topics(options))}
  return
fi
case $before in
{cases}
esac
if [[ $words[CURRENT] == -* ]]; then
  compadd -S '' -- {' '.join(plain(options))}
  return
fi
(( CURRENT == 2 )) && compadd -- help check check-law plot view
_files -g '*.(yaml|yml|opts|h5|csv)'
"""


if __name__ == "__main__":
    FORMS = {"schema": lambda options: json.dumps(schema(options), indent=1) + "\n", "man": man, "bash": bash, "zsh": zsh}
    if len(sys.argv) != 3 or sys.argv[2] not in FORMS:
        sys.exit(__doc__)
    sys.stdout.write(FORMS[sys.argv[2]](read(sys.argv[1])))
