"""JSON with the line of every value: objects and lists that remember where they and their members stand."""

import json
import re

from refusal import fail

SPACE = re.compile(r"(?:[ \t\r\n]|//[^\n]*|/\*.*?\*/)*", re.DOTALL)  # comments as jsoncpp takes them
NUMBER = re.compile(r"-?(?:0|[1-9]\d*)(?:\.\d+)?(?:[eE][-+]?\d+)?")
WORDS = {"true": True, "false": False, "null": None}


class Object(dict):
    """`lines`: of its keys. `repeated`: lines of keys that stand there again; the last value counts, as in jsoncpp."""

    def __init__(self, line):
        super().__init__()
        self.line, self.lines, self.repeated = line, {}, {}


class Array(list):
    """`lines`: of its elements."""

    def __init__(self, line):
        super().__init__()
        self.line, self.lines = line, []


class Parser:
    def __init__(self, file, text):
        self.file, self.text, self.at = file, text, 0

    def line(self, at=None):
        return self.text.count("\n", 0, self.at if at is None else at) + 1

    def fail(self, what):
        fail(f"{self.file}:{self.line()}: is not JSON: {what}; correct this line or the one before")

    def skip(self):
        self.at = SPACE.match(self.text, self.at).end()

    def take(self, wanted):
        self.skip()
        if not self.text.startswith(wanted, self.at):
            self.fail(f"expected '{wanted}'" + (f", not '{self.text[self.at]}'" if self.at < len(self.text) else ", not the file's end"))
        self.at += len(wanted)

    def next_is(self, wanted):
        self.skip()
        return self.text.startswith(wanted, self.at)

    def value(self, depth=0):
        self.skip()
        if depth > 64:
            self.fail("more than 64 levels")
        if self.next_is("{"):
            return self.object(depth)
        if self.next_is("["):
            return self.array(depth)
        if self.next_is('"'):
            return self.string()
        for word, meaning in WORDS.items():
            if self.next_is(word):
                self.at += len(word)
                return meaning
        if match := NUMBER.match(self.text, self.at):
            self.at = match.end()
            return json.loads(match[0])
        self.fail("expected a value" if self.at < len(self.text) else "the file ends early")

    def string(self):
        start = self.at
        try:
            word, self.at = json.decoder.scanstring(self.text, start + 1)
        except json.JSONDecodeError as error:
            self.fail(error.msg)
        return word

    def object(self, depth):
        out = Object(self.line())
        self.take("{")
        if self.next_is("}"):
            self.at += 1
            return out
        while True:
            self.skip()
            line = self.line()
            if not self.next_is('"'):
                self.fail("expected a key in quotation marks")
            key = self.string()
            self.take(":")
            if key in out:
                out.repeated[key] = line
            out[key], out.lines[key] = self.value(depth + 1), line
            if not self.next_is(","):
                self.take("}")
                return out
            self.at += 1

    def array(self, depth):
        out = Array(self.line())
        self.take("[")
        if self.next_is("]"):
            self.at += 1
            return out
        while True:
            self.skip()
            out.lines.append(self.line())
            out.append(self.value(depth + 1))
            if not self.next_is(","):
                self.take("]")
                return out
            self.at += 1


def read_json(file):
    try:
        text = file.read_text(encoding="utf-8-sig")
    except UnicodeDecodeError:
        fail(f"{file}: is not a text in UTF-8; save it as such")
    except OSError as error:
        fail(f"{file}: cannot be read: {error.strerror}")
    parser = Parser(file, text)
    value = parser.value()
    parser.skip()
    if parser.at < len(text):
        parser.fail("more text after the end")
    return value
