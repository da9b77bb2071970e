"""The run from event to event, and its recording."""
