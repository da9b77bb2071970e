"""A virtual laboratory: a tissue is tested on coupons, and compared with what is known of it.

Each test is a scene like any other, compiled and run by the pipeline. It is made of the text
that declares the tissue, and of a coupon with its loads. Nothing is computed a second way.
"""
