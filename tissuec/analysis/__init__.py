"""Virtual tests of tissues, natural modes, and the stiffness and waves of bodies."""
