"""The tests, in the rooms of the sources they are about; what several of them need is in `tests.support`."""
