"""Spring nets that stand for matter: from Young's modulus and density to springs and masses."""
