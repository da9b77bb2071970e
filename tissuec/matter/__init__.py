"""Spring nets that represent matter: from Young's modulus and density to springs and masses."""
