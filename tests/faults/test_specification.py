"""Faults as short text."""

import pytest

from ftac_gym.faults import KINDS, AttitudeSpike, Bias, LossOfEffectiveness, Seizure, SensorFault, StarTrackerOutage
from ftac_gym.faults.specification import EXAMPLES, SAMPLES, name_of, parse


def test_kind_wheel_and_onset():
    fault = parse("seizure:2@15")
    assert fault == Seizure(wheel=2, onset=15.0, brake=2.0)
    assert parse(" Seizure : 2 @ 15 ") == fault
    assert parse("seizure:2") == Seizure(wheel=2, onset=0.0, brake=2.0)


def test_fields_ranges_and_words():
    fault = parse("loss-of-effectiveness:0@10..20,effectiveness=0.3, rise=2")
    assert fault == LossOfEffectiveness(wheel=0, onset=(10.0, 20.0), effectiveness=0.3, rise=2.0)
    # With a magnitude of its own, a bias has nothing of the example's sinusoid.
    assert parse("bias:1,constant=0.02,random_sign=true") == Bias(wheel=1, constant=0.02, random_sign=True)
    assert parse("attitude_spike,angle=0.1") == AttitudeSpike(angle=0.1, period=15.0, on_time=0.3)
    assert parse("star_tracker_outage@20,duration=30") == StarTrackerOutage(onset=20.0, duration=30.0)


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: kind.__name__)
def test_every_kind_has_a_name_that_is_understood(kind):
    text = name_of(kind) + ("" if issubclass(kind, SensorFault) else ":1") + "@5"
    fault = parse(text)
    assert type(fault) is kind and fault.onset == 5.0


@pytest.mark.parametrize("text", SAMPLES)
def test_the_samples_of_the_message_are_understood(text):
    parse(text)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("seizzure:2@15", r"fault must have the form KIND:WHEEL@ONSET.*'seizure:2@15'.*'lock_in_place'.*, got 'seizz"),
        ("", "fault must have the form"),
        ("2@15", "fault must have the form"),
        ("seizure@15", "fault needs a WHEEL, as in 'seizure:2@15', got 'seizure@15'"),
        ("seizure:two@15", "fault needs a WHEEL"),
        ("seizure:-1@15", "fault needs a WHEEL"),
        ("gyro_bias_step:1@15", "fault affects no wheel: write 'gyro_bias_step@15', got"),
        ("seizure:2@soon", r"ONSET must be a number \[s\]"),
        ("seizure:2@", r"ONSET must be a number \[s\]"),
        ("seizure:2@15,break=3", r"seizure has the fields \[.*'brake'.*\], given as FIELD=VALUE, got 'break=3'"),
        ("seizure:2@15,brake", "seizure has the fields"),
        ("seizure:2@15,wheel=1", "seizure has the fields"),
        ("seizure:2@15,brake=0.5", "brake must exceed 1"),
        ("seizure:2@15,brake=strong", "brake must be a number, got 'strong'"),
        ("seizure:2@-3", "onset must not be negative"),
        ("seizure:2@nan", "onset must be finite"),
        ("seizure:2@1e999", "onset must be finite"),
        ("seizure:²@15", "fault needs a WHEEL, as in 'seizure:2@15', got 'seizure:²@15'"),
        ("seizure:" + "9" * 5000, "fault needs a WHEEL"),
        ("seizure:2@15,brake=2,brake=3", "seizure must have every field once, got 'brake=3'"),
        ("seizure:2@15,brake=true", "brake must be a number, got True"),
        ("hard_over:1,random_sign=1", "random_sign must be True or False, got 1.0"),
        ("x" * 5000, r"fault must have the form .*, got 'xxx"),
        (b"seizure:2", "fault must be text of the form KIND"),
    ],
)
def test_bad_specifications_are_refused_with_what_would_be_right(text, message):
    with pytest.raises(ValueError, match=message) as error:
        parse(text)
    assert len(str(error.value)) <= 500


def test_every_kind_of_the_package_has_an_example():
    assert set(EXAMPLES) == {kind.kind for kind in KINDS}
