"""The engine: steps a state from event to event with any integrator on either backend."""
