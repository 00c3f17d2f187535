"""The task: scenario, episodes and all their parts."""
