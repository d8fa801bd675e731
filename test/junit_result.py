"""Runs the unittest cases of a module and leaves the result file of JUnit that catkin counts."""

import time
import unittest
from pathlib import Path
from xml.sax.saxutils import quoteattr


class _Recorder(unittest.TextTestResult):
    """Remembers what a result file of JUnit holds."""

    def __init__(self, *arguments, **named):
        super().__init__(*arguments, **named)
        self.cases = []

    def startTest(self, test):
        super().startTest(test)
        self._began = time.monotonic()

    def stopTest(self, test):
        problems = [text for case, text in self.failures + self.errors if case is test]
        skipped = [why for case, why in self.skipped if case is test]
        inner = f"<failure message={quoteattr(problems[0][-400:])}/>" if problems else ""
        inner += f"<skipped message={quoteattr(skipped[0])}/>" if skipped else ""
        self.cases.append(f"<testcase classname={quoteattr(type(test).__name__)} "
                          f"name={quoteattr(test.id().split('.')[-1])} "
                          f'time="{time.monotonic() - self._began:.3f}">{inner}</testcase>')
        super().stopTest(test)


def run(module, name: str, result_file) -> int:
    """Exit status; `result_file`: path, or None for no file."""
    suite = unittest.defaultTestLoader.loadTestsFromModule(module)
    result = unittest.TextTestRunner(resultclass=_Recorder, verbosity=2).run(suite)
    bad = len(result.failures) + len(result.errors)
    if result_file is not None:
        path = Path(result_file)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(
            f'<testsuite name={quoteattr(name)} tests="{len(result.cases)}" failures="{bad}" '
            f'errors="0">{"".join(result.cases)}</testsuite>\n')
    return 1 if bad else 0
