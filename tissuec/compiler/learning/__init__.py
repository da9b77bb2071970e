"""Learn blocks bound to the network: what is compared with data, and what may change."""
