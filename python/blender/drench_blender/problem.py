"""Errors that the user can correct, and messages of the program with the names of Blender's objects."""

import re


class Problem(Exception):
    """Input that cannot be simulated, or a program that cannot be used. One line: what, where and what to do."""


class Names:
    """The objects behind the numbers that the program uses in its messages."""

    def __init__(self, cloths=(), bodies=(), sources=(), blocks=(), jets=(), rains=(), mesh_jets=(),
                 sprays=()):
        self.cloths, self.bodies, self.sources = list(cloths), list(bodies), list(sources)
        # numbered from 0 in messages
        self.blocks, self.jets, self.rains, self.mesh_jets = list(blocks), list(jets), list(rains), list(mesh_jets)
        self.sprays = list(sprays)

    def as_dict(self):
        return {key: list(value) for key, value in vars(self).items()}


def _named(names, number):
    return f"'{names[number]}'" if 0 <= number < len(names) else None


def _replace_keys(text, key, names):
    """cloth.0.friction becomes 'Towel' friction."""
    def name(match):
        found = _named(names, int(match[1]))
        return match[0] if found is None else found + (f" {match[2][1:]}" if match[2] else "")
    return re.sub(rf"(?<![\w.]){key}\.(\d+)((?:\.\w+)*)", name, text)


def _replace_numbers(text, words, names):
    """jet 0 becomes 'Tap'; blocks 0, 1 become 'Bath'."""
    def name(match):
        found = [_named(names, int(number)) for number in match[1].split(", ")]
        if None in found:
            return match[0]
        return ", ".join(dict.fromkeys(found))
    return re.sub(rf"(?<![\w'])(?:{words}) (\d+(?:, \d+)*)(?![\w.]*\.\d)", name, text)


def with_names(text, names):
    """One line of the program for the user: without the place in the scene file, with objects instead of numbers."""
    text = re.sub(r"^drench: ", "", text.strip())
    text = re.sub(r"^[^\s:]*(?:[A-Za-z]:)?[^:]*\.yaml:(?:\d+:\d+:)? ?", "", text)
    text = _replace_keys(text, "cloth", names.cloths)
    text = _replace_keys(text, "bodies", names.bodies)
    text = _replace_keys(text, r"fluid\.sources", names.sources)
    for name in names.bodies:
        text = text.replace(f"body '{name}'", f"'{name}'")
    text = _replace_numbers(text, "blocks?|(?:mesh|sphere|particle) source", names.blocks)
    text = _replace_numbers(text, "jet|jets", names.jets)
    text = _replace_numbers(text, "rain", names.rains)
    text = _replace_numbers(text, "mesh_jet", names.mesh_jets)
    text = _replace_numbers(text, "spray", names.sprays)
    return re.sub(r"^(?:fluid\.sources: )?(?:fluid: )?(?=')", "", text)
