# SPDX-License-Identifier: Apache-2.0
"""The agent named: the seed's own answers, silence of detectors, placards, lies, what is next."""

import math
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_dispersion.identification.evidence import Evidence, Report
from rocsafe_dispersion.identification.flight_reports import flight_reports
from rocsafe_dispersion.identification.posterior import IdentificationOptions, identify
from rocsafe_dispersion.identification.sensor_report import SensorReport, seen_share
from rocsafe_dispersion.identification.signatures import NO_AGENT, SOMETHING_ELSE, signatures
from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading

SEED_AGENTS = [name for name, one in agents().items() if one.is_of_seed]
OF_SEED = [name for name in signatures().observations if not name.startswith('sign_')]
# Of one agent or none with 0.001 each, and no wrong report.
SEED_MODEL = IdentificationOptions(
    no_agent=0.999 / (0.999 + 31 * 0.001), something_else=0.0, wrong_report=0.0
)


def said(*true: str) -> Evidence:
    """Return that these observations of the seed are so, and all others not."""
    return Evidence(reports=tuple(Report(observation=n, is_true=n in true) for n in OF_SEED))


def saw(*true: str) -> Evidence:
    """Return that these observations are so."""
    return Evidence(reports=tuple(Report(observation=name, is_true=True) for name in true))


def sensed(un_number: int | None = None, **readings: float) -> Evidence:
    """Return readings of detectors, and a placard."""
    reports = tuple(SensorReport(sensor=kind, reading=value) for kind, value in readings.items())
    return Evidence(sensors=reports, un_number=un_number)


@pytest.mark.parametrize(
    ('true', 'answers'),
    [
        (
            ('smell_camphor', 'effect_vomiting', 'seen_as_liquid'),
            {'soman': 0.9908, NO_AGENT: 0.0051, 'nitrogen_mustard_1': 0.00066, 'tabun': 0.00054},
        ),
        (
            ('smell_chlorine', 'effect_choking', 'seen_as_gas'),
            {'chlorine': 0.9999, 'phosgene': 0.00008},
        ),
    ],
)
def test_the_model_of_the_seed_is_reproduced(true, answers):
    """Its own two examples, computed exactly in reference/dispersion.md section 4."""
    table = signatures().of([*SEED_AGENTS, NO_AGENT])
    found = dict(identify(said(*true), SEED_MODEL, table).probabilities)
    for name, expected in answers.items():
        assert found[name] == pytest.approx(expected, rel=0.04)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(st.sampled_from(OF_SEED), st.booleans()), max_size=6))
def test_posterior_is_that_of_bayes_by_enumeration(reports):
    """Against all combinations of true and false behind the reports, for every hypothesis."""
    table, wrong = signatures().of(['tabun', 'chlorine', 'lewisite', NO_AGENT]), 0.2
    options = IdentificationOptions(no_agent=0.3, something_else=0.0, wrong_report=wrong)
    evidence = Evidence(reports=tuple(Report(observation=n, is_true=t) for n, t in reports))
    found = dict(identify(evidence, options, table).probabilities)
    names = sorted({name for name, _ in reports})
    weights = []
    for row, name in enumerate(table.hypotheses):
        total = 0.0
        for hidden in range(2 ** len(names)):
            truth = {one: bool(hidden >> at & 1) for at, one in enumerate(names)}
            joint = 1.0
            for one, is_true in truth.items():
                share = table.probabilities[row, table.column(one)]
                joint *= share if is_true else 1.0 - share
            for one, is_said in reports:
                joint *= 1.0 - wrong if truth[one] == is_said else wrong
            total += joint
        weights.append(total * (0.3 if name == NO_AGENT else 0.7 / 3.0))
    expected = np.array(weights) / sum(weights)
    assert [found[name] for name in table.hypotheses] == pytest.approx(expected, abs=1e-12)


def test_silence_without_gas_says_nothing():
    """Detectors that nobody knows to have been in gas."""
    silent = sensed(electrochemical_chlorine=0.0, pid_10_6_ev=0.0)
    assert dict(identify(silent).probabilities) == pytest.approx(
        dict(identify(Evidence()).probabilities)
    )


def test_silence_of_a_blind_detector_does_not_speak_against_an_agent():
    """A lamp of 10.6 eV cannot see chlorine: its silence helps chlorine, and hurts ammonia."""
    before = dict(identify(sensed(ion_mobility=5.0)).probabilities)
    after = dict(identify(sensed(ion_mobility=5.0, pid_10_6_ev=0.0)).probabilities)
    assert after['chlorine'] > before['chlorine']
    assert after['ammonia'] < 0.2 * before['ammonia']


def test_silence_counts_only_where_the_other_detector_shows_enough():
    """2 ppm of ammonia read 0.2 ppm in the lamp, near its limit: its silence is no evidence."""
    few = dict(identify(sensed(electrochemical_ammonia=1.5, pid_10_6_ev=0.0)).probabilities)
    much = dict(identify(sensed(electrochemical_ammonia=150.0, pid_10_6_ev=0.0)).probabilities)
    odds = [found['ammonia'] / found[SOMETHING_ELSE] for found in (few, much)]
    assert odds[0] > 3.0 * odds[1]


def test_detectors_that_agree_on_the_amount_name_the_agent():
    """80 ppm of ammonia, that 8 of the lamp confirm; hydrogen sulphide would need 800 and 27."""
    found = identify(sensed(pid_10_6_ev=8.0, electrochemical_ammonia=80.0)).probabilities
    shares = dict(found)
    assert found[0][0] == 'ammonia'
    assert shares['hydrogen_sulphide'] < 0.02 * shares['ammonia']


def test_unknown_ionisation_energy_is_neither_seen_nor_silent():
    """Evidence of the lamp leaves the ratio of two agents of unknown energy."""
    before = dict(identify(Evidence()).probabilities)
    for evidence in (sensed(pid_10_6_ev=5.0), sensed(pid_10_6_ev=0.0, ion_mobility=4.0)):
        found = dict(identify(evidence).probabilities)
        assert found['tabun'] / found['lewisite'] == pytest.approx(
            before['tabun'] / before['lewisite']
        )


def test_placard_is_nearly_certain():
    """And one that names nothing of the table favours those whose number is unknown."""
    assert identify(sensed(un_number=1017)).probabilities[0][0] == 'chlorine'
    assert identify(sensed(un_number=1017)).probabilities[0][1] > 0.98
    other = dict(identify(sensed(un_number=1079)).probabilities)
    assert other['chlorine'] < 0.05 * other['sulphur_dioxide']


def test_what_no_table_explains_is_something_else():
    """Signs of different agents at once, without the smell of any."""
    evidence = saw('smell_fish', 'smell_soap', 'smell_camphor', 'smell_sour', 'effect_vomiting')
    assert identify(evidence).probabilities[0][0] == SOMETHING_ELSE


def test_nothing_observed_by_all_is_no_agent():
    """Everybody denies all."""
    assert identify(said('smell_odourless')).probabilities[0][0] == NO_AGENT


def test_witnesses_of_one_smell_cannot_say_more_than_the_smell():
    """A thousand of them are one certain smell."""
    options = IdentificationOptions(wrong_report=0.1)
    certain = IdentificationOptions(wrong_report=0.0)
    crowd = saw(*['smell_geranium'] * 300)
    assert dict(identify(crowd, options).probabilities) == pytest.approx(
        dict(identify(saw('smell_geranium'), certain).probabilities)
    )


def test_next_observation_is_that_with_the_largest_mean_drop_of_entropy():
    """Against the posteriors after each possible report."""
    evidence = saw('effect_choking')
    found = identify(evidence)
    assert [one.gain_bit for one in found.next_observations] == sorted(
        (one.gain_bit for one in found.next_observations), reverse=True
    )
    one = found.next_observations[0]
    table, options = signatures(), IdentificationOptions()
    share = table.probabilities[:, table.column(one.observation)]
    heard = share * (1.0 - options.wrong_report) + (1.0 - share) * options.wrong_report
    posterior = dict(found.probabilities)
    yes = sum(posterior[n] * p for n, p in zip(table.hypotheses, heard, strict=True))
    after = 0.0
    for is_true, weight in ((True, yes), (False, 1.0 - yes)):
        report = Report(observation=one.observation, is_true=is_true)
        more = Evidence(reports=(*evidence.reports, report))
        after += weight * identify(more).entropy_bit
    assert found.entropy_bit - after == pytest.approx(one.gain_bit, abs=1e-9)


def test_entropy_and_categories():
    """Probabilities are a distribution; those of a category add up."""
    found = identify(saw('smell_bitter_almonds', 'effect_blood'))
    shares = dict(found.probabilities)
    assert sum(shares.values()) == pytest.approx(1.0)
    assert found.entropy_bit == pytest.approx(
        -sum(p * math.log2(p) for p in shares.values() if p > 0.0)
    )
    blood = sum(shares[name] for name, one in agents().items() if one.category == 'blood')
    assert found.categories['blood'] == pytest.approx(blood)
    assert next(iter(found.categories)) == 'blood'


def test_signatures_are_of_the_agents_and_between_0_and_1():
    """And distinguish every two agents of the seed, except those that its table does not."""
    table = signatures()
    assert table.hypotheses == (*agents(), NO_AGENT, SOMETHING_ELSE)
    assert ((table.probabilities > 0.0) & (table.probabilities < 1.0)).all()
    of_seed = table.of(SEED_AGENTS)
    assert of_seed.is_known[:, : len(OF_SEED)].all()
    same = [
        {SEED_AGENTS[a], SEED_AGENTS[b]}
        for a, b in combinations(range(len(SEED_AGENTS)), 2)
        if (of_seed.probabilities[a, :27] == of_seed.probabilities[b, :27]).all()
    ]
    assert len(same) <= 10


def test_selective_cells_are_blind_to_what_they_have_no_response_for_and_others_unknown():
    """An electrochemical cell for chlorine does not see benzene; a metal oxide, nobody knows."""
    assert GAS_SENSORS['electrochemical_chlorine'].sees(agents()['benzene']) is False
    assert GAS_SENSORS['metal_oxide'].sees(agents()['benzene']) is True
    assert GAS_SENSORS['metal_oxide'].sees(agents()['sarin']) is None


def test_flight_takes_readings_of_the_same_air():
    """Of the vehicle with the clearest reading, a minute about it; a single spike is noise."""

    def row(second: int, vehicle: str, sensor: str, raw: float) -> GasFlightReading:
        return GasFlightReading(
            vehicle=vehicle, time_ns=second * 10**9, sensor=sensor, unit='ppm',
            calibration_gas='ammonia', latitude_deg=53.0, longitude_deg=-9.0, altitude_m=10.0,
            raw=raw, corrected=raw, std=0.1, limit=0.1, is_saturated=False,
        )  # fmt: skip

    rows = [row(s, 'rav1', 'electrochemical_ammonia', 40.0 * (95 < s < 105)) for s in range(200)]
    rows += [row(s, 'rav1', 'pid_10_6_ev', 4.0 * (95 < s < 105)) for s in range(200)]
    rows += [row(s, 'rav1', 'electrochemical_chlorine', 9.0 * (s == 100)) for s in range(200)]
    rows += [row(s, 'rav2', 'electrochemical_sulphur_dioxide', 0.0) for s in range(200)]
    rows += [row(300, 'rav1', 'electrochemical_hydrogen_sulphide', 5.0)]
    found = {report.sensor: report.reading for report in flight_reports(rows)}
    assert found == {
        'electrochemical_ammonia': 40.0, 'pid_10_6_ev': 4.0, 'electrochemical_chlorine': 0.0,
    }  # fmt: skip
    assert identify(Evidence(sensors=flight_reports(rows))).probabilities[0][0] == 'ammonia'
    assert flight_reports([]) == ()


@pytest.mark.parametrize(
    ('make', 'message'),
    [
        (lambda: saw('smell_x'), 'observation .smell_x. is not known'),
        (lambda: sensed(nose=1.0), 'sensor .nose. is not known'),
        (lambda: sensed(pid_10_6_ev=-1.0), 'reading'),
        (lambda: sensed(pid_10_6_ev=math.nan), 'reading'),
        (lambda: sensed(un_number=99999), 'un_number = 99999 must be between'),
        (
            lambda: Report(observation='smell_fish', is_true=True, place_deg=(91.0, 0.0)),
            'latitude_deg = 91',
        ),
        (
            lambda: Evidence(sensors=(SensorReport(sensor='metal_oxide', reading=1.0),) * 2),
            'each kind may be given once',
        ),
        (lambda: IdentificationOptions(wrong_report=0.6), 'wrong_report'),
        (
            lambda: IdentificationOptions(no_agent=0.6, something_else=0.6),
            'no_agent . something_else',
        ),
    ],
)
def test_bad_evidence_is_refused(make, message):
    """With one line that names it."""
    with pytest.raises(ValueError, match=message):
        make()


@pytest.mark.slow
def test_drawn_cases_are_named_and_calibrated():
    """With 30 % missing and 10 % wrong reports of eight witnesses; stated shares are kept."""
    rng = np.random.default_rng(11)
    table = signatures().of(SEED_AGENTS)
    options = IdentificationOptions(no_agent=0.0, something_else=0.0, wrong_report=0.1)
    hits, stated, right = 0, [], []
    for _ in range(400):
        row = int(rng.integers(len(SEED_AGENTS)))
        truth = rng.random(len(OF_SEED)) < table.probabilities[row, : len(OF_SEED)]
        reports = [
            Report(observation=name, is_true=bool(truth[at] ^ (rng.random() < 0.1)))
            for _ in range(8)
            for at, name in enumerate(OF_SEED)
            if rng.random() > 0.3
        ]
        found = identify(Evidence(reports=tuple(reports)), options, table).probabilities
        hits += table.hypotheses[row] in [name for name, _ in found[:3]]
        stated.append(found[0][1])
        right.append(found[0][0] == table.hypotheses[row])
    assert hits >= 0.93 * 400
    # Three standard errors of a share of 400.
    assert abs(float(np.mean(stated)) - float(np.mean(right))) < 0.07


def test_a_selective_cell_names_its_gas():
    """It sees few other substances; a reading just above the limit of a lamp may be its drift."""
    found = identify(sensed(electrochemical_chlorine=8.0, pid_10_6_ev=0.05)).probabilities
    assert found[0][0] == 'chlorine'
    drifted = identify(sensed(electrochemical_chlorine=8.0, pid_10_6_ev=0.12)).probabilities
    assert 'chlorine' in [name for name, _ in drifted[:3]]
    assert seen_share('electrochemical_chlorine') < 0.1 < seen_share('metal_oxide')
