"""A small engine for TextMate grammars, with Python's regular expressions.

It knows what the grammar uses: match, begin and end, captures, include. Of rules that match at
one place the first one wins, and the end of the innermost rule before all of them.
"""

import re
from functools import cache
from typing import Any

from msgspec import Struct

Rule = dict[str, Any]


@cache
def compiled(pattern: str) -> re.Pattern[str]:
    return re.compile(pattern)


class Engine(Struct):
    """Tokenises texts line by line, as editors do."""

    grammar: Rule

    def tokens(self, text: str) -> list[tuple[int, int, str]]:
        """Return start, stop and scope of every stretch that has a scope of its own."""
        found: list[tuple[int, int, str]] = []
        stack: list[Rule] = [{"patterns": self.grammar["patterns"]}]
        start = 0
        for line in text.split("\n"):
            found += ((start + a, start + b, scope) for a, b, scope in self._line(line, stack))
            start += len(line) + 1
        return found

    def _line(self, line: str, stack: list[Rule]):
        place, turns = 0, 0
        while place <= len(line):
            turns += 1
            assert turns < 10_000, f"the grammar does not get on in {line!r}"
            rule, found = self._next(line, place, stack)
            if found is None:
                return
            if rule is stack[-1]:
                yield from self._captured(found, rule.get("endCaptures", {}))
                stack.pop()
                stuck = False
            elif "begin" in rule:
                yield from self._captured(found, rule.get("beginCaptures", {}))
                stack.append(rule)
                stuck = False
            else:
                if "name" in rule and found.end() > found.start():
                    yield found.start(), found.end(), rule["name"]
                yield from self._captured(found, rule.get("captures", {}))
                stuck = found.end() == found.start()
            place = found.end() + stuck

    def _next(self, line: str, place: int, stack: list[Rule]):
        best: tuple[Rule, re.Match[str] | None] = (stack[-1], None)
        if "end" in stack[-1]:
            best = (stack[-1], compiled(stack[-1]["end"]).search(line, place))
        for rule in self._flat(stack[-1]["patterns"]):
            found = compiled(rule.get("match") or rule["begin"]).search(line, place)
            if found and (best[1] is None or found.start() < best[1].start()):
                best = (rule, found)
        return best

    def _flat(self, patterns: list[Rule], depth: int = 0):
        assert depth < 20
        for rule in patterns:
            if "include" in rule:
                inner = self.grammar["repository"][rule["include"].removeprefix("#")]
                rules = [inner] if "match" in inner or "begin" in inner else inner["patterns"]
                yield from self._flat(rules, depth + 1)
            else:
                yield rule

    @staticmethod
    def _captured(found: re.Match[str], captures: Rule):
        for number, what in captures.items():
            start, stop = found.span(int(number))
            if stop > start:
                yield start, stop, what["name"]
