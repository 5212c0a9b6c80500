"""What a person gets of a motion: folders of results, reports, comparisons."""
