"""The calibration report's sentences, from known calibrations."""

from dataclasses import replace

from baxter_dynamics_ros.calibration.term import Fitted
from baxter_dynamics_ros.recordings.contact_intervals import Contact
import numpy as np
import pytest

pytest.importorskip('matplotlib', reason='reports need matplotlib: pip install matplotlib')
pytest.importorskip('jinja2', reason='reports need Jinja: pip install jinja2')


def says(found):
    return {topic: sentence.replace('\u00a0', ' ') for topic, sentence in found}


def test_gain_what_is_left_and_what_bought_it(calibration):
    from baxter_dynamics_ros.report.calibration_findings import findings
    found = says(findings(calibration))
    assert found['Gain'].startswith('On recordings that the fit did not see, the residual is '
                                    'smaller at every joint: s0 −55 %, s1 −50 %, e0 −13 %')
    assert found['What is left'].startswith('s1 has the largest residual, 1.00 N m RMS, which '
                                            'was 2.00 N m.')
    # Bias: six times 50 % and once -10 %.
    assert found['What bought most'].startswith('Bias, which takes 41 % off the residual, then '
                                                'Dahl (13 %); means over the joints. ')
    assert 'more by others: Dahl at s1 (73 %). Kept at no joint: viscous.' in found[
        'What bought most']
    assert '1 of 2 recordings is predicted worse at some joint (e0), most of all laps at e0: ' \
        '0.80 before, 1.20 N m after.' in found['Worse than before']
    assert 'greater: bias at s1; tilt (8 % more, mean over the joints).' in found[
        'Fitted, but no help']
    assert 'by a fit to the other.' in found['Judged by recording']
    assert 'Judged by time' not in found


def test_gain_where_there_is_less_of_it_or_none(calibration):
    from baxter_dynamics_ros.report.calibration_findings import findings

    def gain(*factors):
        judged = [replace(one, after=one.before * factors) for one in calibration.judged]
        return says(findings(replace(calibration, judged=judged)))['Gain']

    assert gain(0.5, 1.2, 0.5, 0.5, 0.5, 0.5, 0.999).endswith(
        'smaller at s0 −50 %, e0 −50 %, e1 −50 %, w0 −50 %, w1 −50 %, and no smaller at s1 +20 %, '
        'w2 0 %.')
    assert 'smaller at no joint: s0 +20 %' in gain(*[1.2] * 6, 30.0)
    assert 'w2 × 30. Keep the settings' in gain(*[1.2] * 6, 30.0)
    assert gain(*[1.0] * 7).endswith('as it was at every joint: nothing was gained.')


def test_contact_is_named_and_errors_are_given_with_and_without(calibration):
    from baxter_dynamics_ros.report.calibration_findings import findings
    contact = Contact('e0', 123.3, 124.4, 8.1, True, 'laps')
    judged = [calibration.judged[0],
              replace(calibration.judged[1], with_contact=2.0 * calibration.judged[1].after)]
    found = says(findings(replace(calibration, contacts=[contact], judged=judged)))
    assert found['Contact'] == (
        'e0 at its stop, 8 N m, from 123.3 to 124.4 s of laps. It is left out of the fit and of '
        'the errors on this page: e0 0.69 N m without it and 1.25 N m with it.')


def test_one_recording_is_judged_by_time_and_laps_repeat(calibration):
    from baxter_dynamics_ros.report.calibration_findings import findings
    one = replace(calibration, by_time=True)
    found = says(findings(one))
    assert 'Judged by recording' not in found
    assert 'Laps repeat' in found['Judged by time']
    assert 'a second recording' in found['Record next'].lower()
    assert found['Gain'].startswith('On parts of the recording that')


def test_what_is_uncertain_and_what_to_record_next(calibration):
    from baxter_dynamics_ros.report.calibration_findings import findings
    found = says(findings(calibration))
    assert found['Not told from zero'].startswith(
        'Bias e1 (0 ± 0.10 N m), bias w0 (0 ± 0.10 N m), bias w1 (0 ± 0.10 N m), '
        'bias w2 (0.06 ± 0.10 N m): ')
    known = [one for one in calibration.parameters if abs(one.value) > one.deviation]
    moment = Fitted('inertial', 0, 'moment y', 'kg m', 0.0, 0.01, 0.02)
    assert 'Not told from zero' not in says(findings(replace(
        calibration, parameters=[*known, moment])))
    for words in ('More recordings', 's1 from −1.9 to 1.0 rad', 'joints named in the warnings'):
        assert words in found['Record next']
    wide = replace(calibration, judged=2 * calibration.judged, notices=(), s1_range=(-2.0, 0.9))
    assert 'Record next' not in says(findings(wide))


def test_what_is_odd_about_the_robot(calibration):
    from baxter_dynamics_ros.report.robot_findings import remarks
    found = says(remarks(calibration))
    assert found['Velocity lag'] == (
        '13.300 ± 0.030 ms, measured; 14 ms are usual on Baxter. The settings keep 14.0 ms: a '
        'difference of less than 1 ms does not matter. Other than the rest: w1 (20.0 ms).')
    assert found['Tilt of the base'] == (
        '1.1° (0° before): 1.0 ± 0.1° forward and 0.5 ± 0.2° to the right.')
    assert found['Offset'] == 'The largest is at s0, 0.50 ± 0.10 N m.'
    assert found['Friction'].startswith('s1 has most, 1.50 N m (Coulomb and Dahl together); 100 %')
    assert 'Spring' not in found and 'Payload' not in found
    more = [Fitted('spring', 1, 'gain', '-', 1.0, 0.9, 0.02),
            Fitted('payload', None, 'mass', 'kg', 0.0, 0.8, 0.1),
            *(Fitted('payload', None, f'center {axis}', 'm', 0.0, value, 0.005)
              for axis, value in zip('xyz', (0.01, -0.02, 0.1)))]
    found = says(remarks(replace(calibration, parameters=more)))
    assert found['Spring'] == '−10 % against the shape it had (gain 0.900 ± 0.020).'
    assert found['Payload'] == ('0.80 ± 0.10 kg, its centre of mass at (10 ± 5, −20 ± 5, '
                                "100 ± 5) mm in the hand's frame.")
    assert not {'Tilt of the base', 'Offset'} & found.keys()


def test_a_lag_that_was_taken_over_and_one_that_could_not_be_measured(calibration):
    from baxter_dynamics_ros.report.robot_findings import remarks
    after = calibration.after.replace({'acceleration.velocity_lag': 0.03})
    lag = calibration.lag._replace(value=0.03, per_joint=np.full(7, 0.03))
    found = says(remarks(replace(calibration, after=after, lag=lag)))
    assert 'have what was measured; before and after' in found['Velocity lag']
    found = says(remarks(replace(calibration, lag=None)))
    assert found['Velocity lag'].startswith('Not measured')
