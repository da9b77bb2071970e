"""The interaction script: verbs, tools and measures, and the plan that they make."""
