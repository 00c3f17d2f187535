"""Programs of the command line: training, evaluation, tuning, reproduction, viewing, studies, synthesis, conversion."""
