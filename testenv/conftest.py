# SPDX-License-Identifier: Apache-2.0
"""What all tests share: the packages of testenv, its support, a built hdstream; the CPU seconds of each test in the report."""

import pathlib
import resource
import sys

import pytest

_TESTENV = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(_TESTENV / "support"), str(_TESTENV)]

import builtPackage  # noqa: E402
import suiteReport  # noqa: E402

builtPackage.PutOnPath()


def _CpuSeconds() -> float:
    """Of this process and of its children that have ended."""
    usages = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(usage.ru_utime + usage.ru_stime for usage in usages)


_START = pytest.StashKey[float]()


@pytest.hookimpl(wrapper=True)
def pytest_runtest_protocol(item):
    item.stash[_START] = _CpuSeconds()
    return (yield)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item, call):
    if call.when == "teardown":  # fixtures that several tests share count for the first and the last of them
        item.user_properties.append((suiteReport.CPU_SECONDS, f"{_CpuSeconds() - item.stash[_START]:.3f}"))
    return (yield)
