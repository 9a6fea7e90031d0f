"""A comparison as plain data for JSON."""

from __future__ import annotations

from typing import Any

from nrp_core.recording.reading.steps import Difference
from nrp_lab.comparison.divergence import Divergence
from nrp_lab.comparison.engines.verdict import EngineVerdict
from nrp_lab.comparison.judgement import Contrast, JudgedPart, Judgement
from nrp_lab.comparison.report import words
from nrp_lab.comparison.result import GridDiff, PairDiff


def grid_data(diff: GridDiff) -> dict[str, Any]:
    """Return a grid without the runs themselves, which are in their folders."""
    return {
        "experiment": diff.name,
        "brains": diff.grid.brains,
        "worlds": diff.grid.worlds,
        "wirings": diff.grid.wirings,
        "seeds": diff.grid.seeds,
        "overrides": diff.grid.overrides,
        "varied": {key: str(values) for key, values in diff.grid.varied.items()},
        "incomplete": diff.incomplete,
        "independent": diff.answer.is_independent,
        "answer": diff.answer,
        "controls": diff.controls,
        "engines": engine_data(diff.engines),
        "advice": words.advice(diff),
        "finding": [one.metric.name for one in diff.finding],
        "metrics": {one.metric.name: _judgement(one) for one in diff.judgements},
        "divergences": [_divergence_data(one) for one in diff.divergences],
        "failures": {str(cell): why for cell, why in diff.failures.items()},
        "results": diff.folder,
    }


def pair_data(diff: PairDiff) -> dict[str, Any]:
    """Return the comparison of two recordings."""
    return {
        "incomplete": diff.incomplete,
        "identical": diff.is_identical,
        "flaws": diff.flaws,
        "engines": engine_data(diff.engines),
        "reservations": diff.reservations,
        "divergence": _divergence_data(diff.divergence),
        "signals": diff.deviations,
        "metrics": [
            {
                "metric": row.metric.name,
                "part": row.part,
                "unit": row.metric.unit,
                "one": row.one,
                "other": row.other,
                "apart": row.apart,
            }
            for row in diff.measured
        ],
    }


def engine_data(verdict: EngineVerdict) -> dict[str, Any]:
    """Return the verdict on the engines, the largest difference first."""
    return {
        "answer": verdict.agreement,
        "agree": verdict.agrees,
        "headline": verdict.headline,
        "new": [one.key for one in verdict.new],
        "known": [one.key for one in verdict.known],
        "problems": verdict.problems,
        "differences": [
            {
                "key": one.key,
                "side": one.side,
                "one": one.one,
                "other": one.other,
                "measure": one.measure.name,
                "part": one.part,
                "difference": one.amount,
                "unit": one.measure.unit,
                "margin": one.margin,
                "in_margins": one.size,
                "known": one.is_known,
            }
            for one in verdict.differences
        ],
    }


def _judgement(judged: Judgement) -> dict[str, Any]:
    return {
        "title": judged.metric.title,
        "unit": judged.metric.unit,
        "answer": judged.answer,
        "parts": {part.name: _part(part) for part in judged.parts},
    }


def _part(part: JudgedPart) -> dict[str, Any]:
    return {
        "answer": part.answer,
        "margin": part.margin,
        "seed_sd": part.sd,
        "resolution": part.resolution,
        "seeds": part.n_seeds,
        "contrasts": [_contrast(one, part.margin) for one in part.contrasts],
        "cells": [cell._asdict() for cell in part.cells],
    }


def _contrast(one: Contrast, margin: float) -> dict[str, Any]:
    return {
        "factor": one.factor,
        "one": one.one,
        "other": one.other,
        "relation": one.relation(margin),
        "difference": one.estimate.mean,
        "interval_90": one.estimate.interval,
        "effect_sd": one.effect_sd,
        "p_equivalent": one.estimate.p_equivalent(margin),
        "p_different_holm": one.p_different,
    }


def _divergence_data(one: Divergence) -> dict[str, Any]:
    return {
        "one": one.one,
        "other": one.other,
        "steps": one.steps,
        "first": None if one.first is None else difference_data(one.first),
        "identical": one.is_identical,
        "visible": one.visible,
    }


def difference_data(first: Difference) -> dict[str, Any]:
    """Return where two runs first differ."""
    return {
        "step": first.step,
        "t_ns": first.t_ns,
        "side": first.group,
        "signal": first.signal,
        "one": first.recorded,
        "other": first.now,
    }
