"""What runs and plans have to say, in words that all commands share."""
