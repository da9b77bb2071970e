"""What differs between two runs, two scenes, or a scene and a run: text, numbers and motion."""
