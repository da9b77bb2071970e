"""Reports on runs, bodies, modes, plans and origins, which commands and pages share."""
