"""Words to numbers: membership functions, rules, and an exact centre of gravity."""
