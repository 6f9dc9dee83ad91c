"""The gap workflow: where a model misses measured data, which physical effect it lacks, and what the effect changes.

Data flow one way: experiments -> preprocessing -> models -> estimation -> validation -> selection -> experiment design
and localisation -> `verdict`, which writes the keys of verdict.json.
"""
