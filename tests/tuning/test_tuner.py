"""What all tuners share: asking, telling, ranking, taking up, and stages as generators."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from random_walk import RandomWalk, bowl

from pitchopt.errors import ComputationError, InputError
from pitchopt.tuning import Candidate, Evaluation, Outcome, Parameter, Space
from pitchopt.tuning.tuner import Proposal


def told(tuner, *results):
    """Evaluations of points that nobody asked for."""
    return [tuner.tell([0.0, 0.1 * i], result) for i, result in enumerate(results)]


# --- asking ---


def test_fewer_come_where_the_tuner_waits():
    tuner = RandomWalk(batch=3)
    first = tuner.ask(2)
    assert [candidate.index for candidate in first] == [0, 1]
    assert [candidate.index for candidate in tuner.ask(5)] == [2]
    assert tuner.ask(5) == []
    assert not tuner.finished
    tuner.tell(first[1], 1.0)
    tuner.tell(first[0], 1.0)
    assert tuner.ask(1) == []
    tuner.tell(tuner.pending[0], 1.0)
    assert len(tuner.ask(5)) == 3


def test_the_last_stage_ends_it():
    tuner = RandomWalk(batch=2, stages=2)
    for _ in range(2):
        for candidate in tuner.ask(9):
            tuner.tell(candidate, bowl(candidate.x))
    assert tuner.finished
    assert tuner.ask(1) == []


def test_a_stage_gets_its_evaluations_in_the_order_of_asking():
    seen = []

    class Watching(RandomWalk):
        def _stages(self):
            points = [Proposal(x=np.array([0.1 * i, 0.5])) for i in range(4)]
            seen.extend((yield points))

    tuner = Watching()
    for candidate in reversed(tuner.ask(4)):
        tuner.tell([0.0, 0.0], 5.0)  # of no stage
        tuner.tell(candidate, candidate.index)
    assert tuner.finished
    assert [evaluation.cost for evaluation in seen] == [0.0, 1.0, 2.0, 3.0]


def test_stages_without_points_are_passed_over():
    class Sparse(RandomWalk):
        def _stages(self):
            yield []
            told = yield [Proposal(x=np.array([0.0, 0.0]))]
            assert len(told) == 1
            assert (yield []) == []

    tuner = Sparse()
    (candidate,) = tuner.ask(3)
    assert not tuner.finished
    tuner.tell(candidate, 1.0)
    assert tuner.finished


@pytest.mark.parametrize("n", [0, -1, 1.5, "many"])
def test_a_bad_number_of_points_is_named(n):
    with pytest.raises(InputError, match="n: got"):
        RandomWalk().ask(n)


def test_a_tuner_needs_a_space_and_a_seed():
    with pytest.raises(InputError, match="space: got list"):
        RandomWalk([])
    with pytest.raises(InputError, match="seed"):
        RandomWalk(seed=-1)


# --- telling ---


def test_a_point_may_be_told_by_what_it_is():
    tuner = RandomWalk()
    candidate = tuner.ask(1)[0]
    assert tuner.tell(candidate.x.tolist(), 3.0).index == candidate.index
    assert tuner.pending == ()


def test_a_point_across_the_turn_is_the_one_that_was_asked_for():
    space = Space([Parameter(name="p", low=0.0, high=1.0, periodic=True)])

    class Once(RandomWalk):
        def _stages(self):
            yield [Proposal(x=np.array([1.0]))]

    tuner = Once(space)
    (candidate,) = tuner.ask(1)
    assert candidate.x[0] == 0.0
    assert tuner.tell([3.0], 1.0).index == 0
    again = Once(space)
    assert again.adopt(candidate).index == 0


def test_points_of_others_are_told_and_count():
    tuner = RandomWalk()
    asked = tuner.ask(3)
    evaluation = tuner.tell([0.3, 0.6], -1.0)
    assert evaluation.index == -1
    assert len(tuner.pending) == 3
    assert tuner.best().evaluation is evaluation
    for candidate in asked:
        tuner.tell(candidate, 1.0)
    assert len(tuner.ask(9)) == 3
    with pytest.raises(InputError, match="b = 7"):
        tuner.tell([0.0, 7.0], 1.0)


def test_a_candidate_is_told_once_and_to_its_own_tuner():
    tuner, other = RandomWalk(seed=1), RandomWalk(seed=2)
    candidate, foreign = tuner.ask(1)[0], other.ask(1)[0]
    with pytest.raises(InputError, match="candidate 0 at"):
        tuner.tell(foreign, 1.0)
    tuner.tell(candidate, 1.0)
    with pytest.raises(InputError, match="not yet told"):
        tuner.tell(candidate, 1.0)
    assert len(tuner.evaluations) == 1


@pytest.mark.parametrize("cost", [np.nan, np.inf, -np.inf])
def test_costs_that_are_no_numbers_are_failures(cost):
    tuner = RandomWalk()
    evaluation = tuner.tell(tuner.ask(1)[0], cost)
    assert evaluation.status == "failed"
    assert np.isnan(evaluation.cost)
    assert "cost or a constraint" in evaluation.message
    with pytest.raises(ComputationError, match="none of 1 evaluations is feasible; the last: the"):
        tuner.best()


def test_a_constraint_that_is_no_number_is_a_failure():
    tuner = RandomWalk()
    assert tuner.tell(tuner.ask(1)[0], 1.0, constraints=[np.nan]).status == "failed"


@pytest.mark.parametrize(
    ("y", "extra", "message"),
    [
        (None, {}, "outcome"),
        ("low", {}, "outcome"),
        ([1.0, 2.0], {}, "outcome"),
        (1.0, {"variance": -1.0}, "variance"),
        (1.0, {"variance": np.nan}, "variance"),
        (1.0, {"constraints": ["tight"]}, "outcome"),
    ],
)
def test_what_is_no_cost_is_named(y, extra, message):
    tuner = RandomWalk()
    candidate = tuner.ask(1)[0]
    with pytest.raises(InputError, match=message):
        tuner.tell(candidate, y, **extra)
    assert tuner.pending == (candidate,)


def test_an_evaluation_is_told_as_it_is_but_for_who_asked():
    tuner = RandomWalk()
    candidate = tuner.ask(1)[0]
    given = Evaluation(
        index=99, x=np.zeros(2), cost=2.0, measures={"load": 3.0}, seconds=4.0, origin="else"
    )
    evaluation = tuner.tell(candidate, given)
    assert evaluation.index == 0
    assert np.array_equal(evaluation.x, candidate.x)
    assert evaluation.origin == "stage 1"
    assert evaluation.measures == {"load": 3.0}
    assert evaluation.seconds == 4.0
    with pytest.raises(InputError, match="that is ok"):
        tuner.tell([0.0, 0.0], dataclasses.replace(given, cost=np.nan))


# --- ranking ---


def test_best_is_the_least_that_is_feasible():
    tuner = RandomWalk()
    with pytest.raises(ComputationError, match="nothing was evaluated"):
        tuner.best()
    told(tuner, 3.0, Outcome(cost=-9.0, constraints=(0.1,)), np.nan, 2.0, 2.0)
    best = tuner.best()
    assert best.cost == 2.0
    assert best.std == 0.0
    assert best.x[1] == pytest.approx(0.3)  # the first of two


def test_merits_put_feasible_before_broken_before_worse_broken():
    tuner = RandomWalk()
    found = told(
        tuner,
        Outcome(cost=1.0, constraints=(0.0,)),
        Outcome(cost=5.0, constraints=(-1.0,)),
        Outcome(cost=-100.0, constraints=(0.25,)),
        Outcome(cost=-200.0, constraints=(0.5,)),
        np.nan,
    )
    assert tuner.merits(found) == pytest.approx([1.0, 5.0, 5.25, 5.5, 9.0])
    assert tuner.merit(found[3]) == pytest.approx(5.5)


def test_merits_before_anything_is_feasible_are_violations():
    tuner = RandomWalk()
    found = told(tuner, np.nan)
    assert np.isinf(tuner.merit(found[0]))
    found += told(
        tuner, Outcome(cost=-9.0, constraints=(2.0, 1.0)), Outcome(cost=7.0, constraints=(1.0, -5))
    )
    assert tuner.merits(found) == pytest.approx([5.0, 3.0, 1.0])


@given(
    st.lists(
        st.one_of(
            st.just(np.nan),
            st.floats(-1e6, 1e6),
            st.builds(
                lambda cost, constraint: Outcome(cost=cost, constraints=(constraint,)),
                st.floats(-1e6, 1e6),
                st.floats(-10, 10),
            ),
        ),
        min_size=1,
        max_size=12,
    )
)
def test_merits_are_all_finite_or_all_infinite_and_agree_with_best(results):
    tuner = RandomWalk()
    found = [tuner.tell([0.0, 0.0], result) for result in results]
    merits = tuner.merits(found)
    assert np.all(np.isfinite(merits)) or np.all(np.isinf(merits))
    if any(e.feasible for e in found):
        assert found[int(np.argmin(merits))].cost == tuner.best().cost
        others = [m for m, e in zip(merits, found, strict=True) if not e.feasible]
        assert all(m > max(e.cost for e in found if e.feasible) for m in others)


# --- taking up ---


def test_a_tuner_that_is_taken_up_goes_on_as_it_would_have():
    whole, again = RandomWalk(), RandomWalk()
    asked = []
    for _ in range(6):
        asked += whole.ask(3)
        for candidate in asked[-3:]:
            whole.tell(candidate, bowl(candidate.x))
    for candidate in asked[:10]:
        taken = again.adopt(candidate)
        assert taken.index == candidate.index
        again.tell(taken, bowl(taken.x))
    for candidate in asked[10:]:
        (new,) = again.ask(1)
        assert np.array_equal(new.x, candidate.x)
        again.tell(new, bowl(new.x))


def test_candidates_of_another_study_are_refused():
    tuner, other = RandomWalk(seed=1), RandomWalk(seed=2)
    candidates = other.ask(2)
    with pytest.raises(InputError, match="number 1, expected 0"):
        tuner.adopt(candidates[1])
    with pytest.raises(InputError, match="another study"):
        tuner.adopt(candidates[0])
    with pytest.raises(InputError, match="expected between"):
        RandomWalk().adopt(Candidate(index=0, x=np.array([9.0, 9.0])))


def test_nothing_is_taken_up_while_the_tuner_waits():
    whole, again = RandomWalk(batch=1), RandomWalk(batch=1)
    first = whole.ask(1)[0]
    whole.tell(first, 1.0)
    second = whole.ask(1)[0]
    again.adopt(first)
    assert again.adopt(second) is None
    again.tell(first, 1.0)
    assert np.array_equal(again.adopt(second).x, second.x)
