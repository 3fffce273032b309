"""A study as people write it: what is fixed, what is drawn, and the cases that follow from it."""

from __future__ import annotations

import itertools
import math
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, ValidationError, field_validator, model_validator

from glenoid.devices import load_device
from glenoid.exo import core_exo
from glenoid.inputs import (
    InputError,
    ReachInput,
    Real,
    Strict,
    Whole,
    build_reach,
    explain,
    laid_over,
    read_mapping,
)
from glenoid.settings import make_generator


def as_numbers(value: Any) -> Any:
    """A finite number or a list of them; nothing else."""
    for entry in value if isinstance(value, list) else [value]:
        if isinstance(entry, bool) or not isinstance(entry, (int, float)) or not math.isfinite(entry):
            raise ValueError("must be a finite number or a list of them")
    return value


Number = Annotated[float | list[float], BeforeValidator(as_numbers)]
Variant = dict[str, Any]
device_by_name = lru_cache(load_device)
KINDS = "a value, {values: [...]}, {min, max} or {mean, sd, min, max}"


class Each(Strict):
    """Every value in turn."""

    values: Annotated[list[Any], Field(min_length=1)]


class Range(Strict):
    """Uniform between two bounds; of a point, each coordinate."""

    min: Number
    max: Number

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if np.shape(self.min) != np.shape(self.max) or np.any(np.asarray(self.min) > np.asarray(self.max)):
            raise ValueError(f"min = {self.min}, max = {self.max}: must be equally many numbers, min <= max")
        return self

    def at(self, share: Any) -> Any:
        """The value below which a share 0..1 of the draws lies."""
        low, high = np.asarray(self.min), np.asarray(self.max)
        return (low + share * (high - low)).tolist()


class Normal(Range):
    """Normal between two bounds, which cut its tails off."""

    mean: Number
    sd: Number

    @model_validator(mode="after")
    def _within(self) -> Self:
        low, mean, high, sd = (np.asarray(value) for value in (self.min, self.mean, self.max, self.sd))
        if not mean.shape == sd.shape == low.shape or np.any(sd <= 0.0) or np.any((mean < low) | (mean > high)):
            raise ValueError(
                f"mean = {self.mean}, sd = {self.sd}: must be as many numbers as min, min <= mean <= max, sd > 0"
            )
        return self

    def at(self, share: Any) -> Any:
        """See Range."""
        from scipy.special import ndtr, ndtri  # takes longer to load than most studies need to be read

        mean, sd = np.asarray(self.mean), np.asarray(self.sd)
        low, high = ((np.asarray(bound) - mean) / sd for bound in (self.min, self.max))
        value = mean + sd * ndtri(ndtr(low) + share * (ndtr(high) - ndtr(low)))
        return np.clip(value, self.min, self.max).tolist()


class Study(Strict):
    """A population study. Groups and tasks give keys of a reach file, with dots between sections, fixed or drawn."""

    name: str = ""
    note: str = ""
    seed: Annotated[Whole, Field(ge=0)] = 1
    draws: Annotated[
        Whole, Field(ge=1, le=1_000_000, description="of every combination in which something is drawn")
    ] = 1
    reach: Variant = Field(default={}, description="common to all cases, as in a reach file")
    groups: Annotated[dict[str, Variant], Field(default={"all": {}}, min_length=1)]
    tasks: Annotated[dict[str, Variant], Field(default={"reach": {}}, min_length=1)]
    exoskeletons: list[str] = Field(default=[], description="names or files; none: the arm alone")
    targets_for_stature_m: Annotated[Real | None, Field(gt=0.0, description="targets grow with the person")] = None

    @field_validator("exoskeletons")
    @classmethod
    def _each_once(cls, names: list[str]) -> list[str]:
        if twice := [name for k, name in enumerate(names) if name in names[:k]]:
            raise ValueError(f"{twice[0]} stands twice")
        return names


@dataclass(frozen=True)
class Case:
    """One reach of a study: what the combination is called, and the keys in which it differs from the common reach."""

    number: int
    group: str
    task: str
    draw: int
    exo: str | None
    values: Variant


def parse_value(value: Any, where: str) -> Any:
    """A fixed value as it is, or what it is drawn from. InputError names the key."""
    if not isinstance(value, dict):
        return value
    kind = next((kind for kind in (Each, Normal, Range) if kind.model_fields.keys() == value.keys()), None)
    if kind is None:
        raise InputError(f"{where} = {value}: must be {KINDS}")
    try:
        return kind.model_validate(value)
    except ValidationError as error:
        raise explain(error, where) from error


def load_study(path: Path) -> Study:
    """A study from a YAML file; the common reach, every key and every bound is checked before anything runs.

    Raises:
        InputError: where, key, value and rule, a line each.
    """
    try:
        study = Study.model_validate(read_mapping(path))
    except ValidationError as error:
        raise explain(error, str(path)) from error
    for section in ("groups", "tasks"):
        for name, variant in getattr(study, section).items():
            for key, value in variant.items():
                variant[key] = parse_value(value, f"{path}: {section}.{name}.{key}")
    check_bounds(study, path)
    return study


def check_bounds(study: Study, path: Path) -> None:
    """Builds every fixed value, every bound and every value in turn, the others in the middle. InputError if one is refused."""
    build_reach(study.reach, f"{path}: reach")
    for (group, first), (task, second) in itertools.product(study.groups.items(), study.tasks.items()):
        if twice := first.keys() & second.keys():
            raise InputError(f"{path}: {sorted(twice)[0]}: stands in groups.{group} and in tasks.{task}")
        middle = {key: representatives(value)[0] for key, value in (first | second).items()}
        for key, value in (first | second).items():
            for bound in representatives(value):
                check_case(study, middle | {key: bound}, f"{path}: groups.{group}, tasks.{task}")
        check_case(study, middle, f"{path}: groups.{group}, tasks.{task}")


def check_case(study: Study, values: Variant, origin: str) -> None:
    """Refuses what the core refuses before anything moves: persons, limits, devices for the other arm."""
    reach = reach_of(study, values, origin)
    try:
        make_generator(reach)
        for exo in study.exoskeletons:
            core_exo(device_by_name(exo), reach.subject)
    except InputError as error:
        raise InputError("\n".join(f"{origin}: {line}" for line in str(error).splitlines())) from error


def representatives(value: Any) -> list[Any]:
    """A value in the middle first, and those that must be valid for all others to be."""
    if isinstance(value, Each):
        return value.values
    return [value.at(share) for share in (0.5, 0.0, 1.0)] if isinstance(value, Range) else [value]


def nested(values: Variant, origin: str) -> Variant:
    """Keys with dots as sections in sections. InputError if a section is given as a value too."""
    out: Variant = {}
    for key, value in values.items():
        *sections, last = key.split(".")
        place = out
        for section in sections:
            place = place.setdefault(section, {})
            if not isinstance(place, dict):
                raise InputError(f"{origin}: {key}: {section} = {place!r} is given as a whole beside it")
        place[last] = value
    return out


def reach_of(study: Study, values: Variant, origin: str) -> ReachInput:
    """The reach of a case. InputError names origin, key, value and rule."""
    reach = build_reach(laid_over(study.reach, nested(values, origin)), origin)
    if study.targets_for_stature_m is None:
        return reach
    x, y, z = np.array(reach.target_m) * (reach.subject.stature_m / study.targets_for_stature_m)
    return reach.model_copy(update={"target_m": (float(x), float(y), float(z))})


def drawn(study: Study, draw: int, where: str, value: Any) -> Any:
    """A number of its own stream for each key: other keys, groups, tasks and devices change nothing about it."""
    if not isinstance(value, Range):
        return value
    stream = np.random.default_rng([study.seed, draw, zlib.crc32(where.encode())])
    return value.at(stream.random(np.shape(value.min)))


def cases_of(study: Study) -> Iterator[Case]:
    """Groups by tasks by values in turn by draws by devices. The same person and target meet every device."""
    numbers = itertools.count()
    for (group, first), (task, second) in itertools.product(study.groups.items(), study.tasks.items()):
        places = {key: f"groups.{group}.{key}" for key in first} | {key: f"tasks.{task}.{key}" for key in second}
        variant = first | second
        turns = {key: value.values for key, value in variant.items() if isinstance(value, Each)}
        draws = study.draws if any(isinstance(value, Range) for value in variant.values()) else 1
        for turn, draw in itertools.product(itertools.product(*turns.values()), range(draws)):
            fixed = variant | dict(zip(turns, turn, strict=True))
            values = {key: drawn(study, draw, places[key], value) for key, value in fixed.items()}
            for exo in study.exoskeletons or (None,):
                yield Case(next(numbers), group, task, draw, exo, values)
