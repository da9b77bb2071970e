"""Learning of words: scales whose words move, and rules that are revised."""
