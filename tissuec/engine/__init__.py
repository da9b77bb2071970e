"""The engine: steps a situation from event to event with any integrator on either tier."""
