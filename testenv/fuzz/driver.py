# SPDX-License-Identifier: Apache-2.0
"""Runs cases in worker processes under limits of memory and time, restarts workers that die, and keeps what was found:
the case's files and how to run it again. Linux: time is counted from /proc, so that a machine that is busy, or a worker that
somebody has stopped, is no hang."""

import json
import os
import pathlib
import re
import resource
import select
import shutil
import signal
import subprocess
import sys
import time
from dataclasses import dataclass

_POLL_SECONDS = 0.5
CPU_SECONDS = 120  # of one case; the first one of a cache folder builds kernels
_IDLE_POLLS = 240  # without any CPU time
_MEMORY_BYTES = 12 << 30  # address space; OpenCL and TBB reserve more than they use
_FILE_BYTES = 2 << 30
_WORKER_BYTES = 3 << 30  # resident; a worker with more is replaced
_CASES_PER_WORKER = 300
_KEPT_PER_KIND_OF_FINDING = 3


@dataclass
class Finding:
    number: int
    wrong: str
    folder: pathlib.Path  # its files, once they are saved


def _SetLimits() -> None:
    if not pathlib.Path("/dev/nvidiactl").exists():  # its driver reserves all addresses there are
        resource.setrlimit(resource.RLIMIT_AS, (_MEMORY_BYTES, _MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_FSIZE, (_FILE_BYTES, _FILE_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))


class Worker:
    """One process of worker.py."""

    def __init__(self, kind: str, seed: int, folder: pathlib.Path):
        folder.mkdir(parents=True, exist_ok=True)
        self.log = folder.parent / f"{folder.name}.log"
        self.numCases = 0
        with open(self.log, "wb") as log:
            self._process = subprocess.Popen(
                [sys.executable, "-X", "faulthandler", str(pathlib.Path(__file__).with_name("worker.py")), kind, str(seed), str(folder)],
                stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=log, preexec_fn=_SetLimits)

    def Run(self, number: int) -> dict:
        """The worker's report, or a report of how it ended; then it is of no more use (`isDead`)."""
        self.numCases += 1
        try:
            self._process.stdin.write(f"{number}\n".encode())
            self._process.stdin.flush()
        except BrokenPipeError:
            pass  # the wait below says how it ended
        begin, before, idlePolls = self._CpuSeconds(), -1.0, 0
        while True:
            if select.select([self._process.stdout], [], [], _POLL_SECONDS)[0]:
                line = self._process.stdout.readline()
                return json.loads(line) if line else self._Ended()
            now, state = self._CpuSeconds(), self._State()
            idlePolls = idlePolls + 1 if now == before and state in "SD" else 0
            before = now
            if now - begin > CPU_SECONDS or idlePolls > _IDLE_POLLS:
                self._process.send_signal(signal.SIGABRT)  # the fault handler says where it is
                time.sleep(1)
                self.Stop()
                return {"wrong": f"hangs: {now - begin:.0f} s of CPU time, {self._WhereItWas()}", "bytes": 0}

    def _Ended(self) -> dict:
        code = self._process.wait()
        how = signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return {"wrong": f"the process ended: {how}, {self._WhereItWas()}", "bytes": 0}

    def _WhereItWas(self) -> str:
        lines = self.log.read_text(errors="replace").splitlines()
        where = [line.strip() for line in lines if "terminate" in line or "what()" in line or "Fatal" in line or "Error" in line]
        return " | ".join(where[-4:])[:400]

    @property
    def isDead(self) -> bool:
        return self._process.poll() is not None

    def _Stat(self) -> list:
        try:
            return pathlib.Path(f"/proc/{self._process.pid}/stat").read_text().rsplit(")", 1)[1].split()
        except OSError:
            return ["Z"] + ["0"] * 20

    def _State(self) -> str:
        return self._Stat()[0]

    def _CpuSeconds(self) -> float:
        return sum(map(int, self._Stat()[11:13])) / os.sysconf("SC_CLK_TCK")

    def Stop(self) -> None:
        self._process.kill()
        self._process.wait()
        self._process.stdin.close()
        self._process.stdout.close()


def _Signature(wrong: str) -> str:
    return re.sub(r"\d+|0x\w+", "#", wrong)[:160]


class Fuzzer:
    """Cases of one kind, from `first` on."""

    def __init__(self, kind: str, seed: int, folder, onFinding=lambda finding: None):
        self.kind, self.seed, self.folder = kind, seed, pathlib.Path(folder).resolve()
        self.findings, self.numCases = [], 0
        self._counts, self._onFinding, self._worker = {}, onFinding, None

    def RunFor(self, seconds: float, first: int = 0) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.RunCase(first + self.numCases)
        self.Close()

    def RunCount(self, count: int, first: int = 0) -> None:
        for number in range(first, first + count):
            self.RunCase(number)
        self.Close()

    def RunCase(self, number: int) -> str:
        if self._worker is None or self._worker.isDead:
            self._worker = Worker(self.kind, self.seed, self._CaseFolder())
        report = self._worker.Run(number)
        self.numCases += 1
        if report["wrong"]:
            self._Keep(number, report["wrong"])
        if report["bytes"] > _WORKER_BYTES or self._worker.numCases >= _CASES_PER_WORKER:
            self.Close()
        return report["wrong"]

    def _CaseFolder(self) -> pathlib.Path:
        return self.folder / f"{self.kind}-case"

    def _Keep(self, number: int, wrong: str) -> None:
        count = self._counts[_Signature(wrong)] = self._counts.get(_Signature(wrong), 0) + 1
        if count > _KEPT_PER_KIND_OF_FINDING:
            return
        finding = Finding(number, wrong, self.folder / f"{self.kind}-{self.seed}-{number}")
        shutil.rmtree(finding.folder, ignore_errors=True)
        shutil.copytree(self._CaseFolder(), finding.folder, symlinks=True)
        text = f"{wrong}\n\nfuzz.py {self.kind} --seed {self.seed} --case {number}\n\n"
        log = self._worker.log.read_text(errors="replace")[-4000:]
        (finding.folder / "finding.txt").write_text(text + log, encoding="utf-8")
        self.findings.append(finding)
        self._onFinding(finding)

    def Close(self) -> None:
        if self._worker is not None:
            self._worker.Stop()
            self._worker = None

    def Counts(self) -> dict:
        """How often each kind of finding was met, digits left out."""
        return dict(self._counts)
