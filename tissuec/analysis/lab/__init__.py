"""A virtual laboratory: a tissue is tested on coupons and compared with evidence.

Each test is a scene like any other, compiled and run by the pipeline. It consists of the text
that declares the tissue, and of a specimen with its loads. Each result is checked by an
independent method.

Shared arguments:
    bench: The bench of the tissue.
    coupon: The coupon that is tested.
    mode: Loading mode, one of ``known_curves.MODES``.
    tension: Result of the tension test.
    guess: Estimate of the modulus [Pa].
    stresses: Stresses [Pa].
    rupture: Whether the coupon can break between its gauges.
    script: Orders with their times.
    faces: Faces of which there are sets.
    watched: What is logged, such as "position of lab x0".
    reading: What was logged.
"""
