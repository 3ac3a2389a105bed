#!/usr/bin/python3
# SPDX-License-Identifier: BSD-3-Clause
# Run by: make nightly
"""The job array for Slurm in a real one: a cluster of this machine alone, with its three daemons, in a scratch directory.

Where it is not installed (packages slurmctld, slurmd, slurm-client, munge) or whoever asks is not root, whom slurmd wants, it is skipped."""

import os
import re
import shutil
import socket
import subprocess
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "support"))
from daemon import free_ports  # noqa: E402
from test_workflows import HERE, RESULTS, SWEEP, Workflow, wait_for  # noqa: E402

NEEDED = ("slurmctld", "slurmd", "munged", "sbatch", "scontrol")
CONF = """ClusterName=meniscus
SlurmctldHost={host}(127.0.0.1)
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket={home}/munge.socket,cred_expire=5
SlurmctldPort={first}
SlurmdPort={second}
SlurmctldPidFile={home}/slurmctld.pid
SlurmdPidFile={home}/slurmd.pid
StateSaveLocation={home}/state
SlurmdSpoolDir={home}/spool
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
SchedulerParameters=batch_sched_delay=0,sched_min_interval=0
SlurmdParameters=config_overrides
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""


@unittest.skipUnless(all(map(shutil.which, NEEDED)), "needs the packages slurmctld, slurmd, slurm-client and munge")
@unittest.skipUnless(os.geteuid() == 0, "slurmd wants root")
class Slurm(Workflow):
    def setUp(self) -> None:
        super().setUp()
        host, port = socket.gethostname().split(".")[0], free_ports()
        conf = self.home / "slurm.conf"
        conf.write_text(CONF.format(host=host, home=self.home, first=port, second=port + 1))
        (self.home / "state").mkdir()
        (self.home / "munge.key").write_bytes(os.urandom(128))
        (self.home / "munge.key").chmod(0o600)
        self.environment |= {"SLURM_CONF": str(conf), "PATH": f"{os.environ['PATH']}:/usr/sbin"}
        self.daemon("munged", "--foreground", "--force", f"--key-file={self.home}/munge.key", f"--socket={self.home}/munge.socket",
                    f"--pid-file={self.home}/munged.pid", f"--log-file={self.home}/munged.log", f"--seed-file={self.home}/munged.seed")
        wait_for((self.home / "munge.socket").exists)
        self.daemon("slurmctld", "-D", "-f", str(conf), "-L", f"{self.home}/slurmctld.log")
        self.daemon("slurmd", "-D", "-f", str(conf), "-N", host, "-L", f"{self.home}/slurmd.log")
        wait_for(lambda: re.search(r"State=(IDLE|MIXED)\b", self.ask("scontrol", "show", "node")), 40)

    def daemon(self, *words: str) -> None:
        with open(self.home / f"{words[0]}.out", "w") as out:
            process = subprocess.Popen(words, env=self.environment, cwd=self.home, stdout=out, stderr=out)
        self.addCleanup(self.end, process)

    @staticmethod
    def end(process: "subprocess.Popen[bytes]") -> None:
        process.terminate()
        try:
            process.wait(60)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()

    def ask(self, *words: str) -> str:
        return subprocess.run(words, env=self.environment, cwd=self.home, text=True, capture_output=True, timeout=30).stdout

    def submit(self, array: str, settings: str) -> str:
        self.environment |= SWEEP | {"SETTINGS": settings}
        job = self.do("sbatch", "--parsable", f"--array={array}", "--cpus-per-task=1", HERE / "slurm.sh").strip()
        self.addCleanup(wait_for, lambda: "JobId" in (left := self.jobs(job)) and not re.search("JobState=(PENDING|RUNNING|COMPLETING)", left), 30)
        self.addCleanup(self.ask, "scancel", job)
        return job

    def jobs(self, job: str) -> str:
        return self.ask("scontrol", "show", "job", job)

    def test_a_sweep_comes_to_its_end(self) -> None:
        job = self.submit("0-3", SWEEP["SETTINGS"])
        wait_for(lambda: self.jobs(job).count("JobState=COMPLETED") == 4, 90)
        self.assertEqual(sorted(str(p.relative_to(self.home)) for p in self.home.glob("scheme~*/*.json")), sorted(RESULTS))

    def test_a_task_that_runs_out_of_time_goes_on_where_it_was(self) -> None:
        job = self.submit("1", "end_time=1000")
        directory = self.home / "scheme~riemann/resolution~10.run"
        wait_for(lambda: list(directory.glob("snapshot-*.hdf")), 40)
        self.ask("scancel", "--batch", "--signal=USR1", f"{job}_1")  # as --signal has it sent before the time is over
        wait_for(lambda: list(directory.glob("checkpoint-*.hdf")), 20)
        wait_for(lambda: re.search(r"Restarts=1\b", self.jobs(job)), 20)
        log = self.home / f"meniscus-{job}_1.log"
        # The first line of its progress says where it begins.
        again = wait_for(lambda: re.search(r"exit code 75\n(?:.*\n)*?.* step (\d+)", log.read_text()), 90)
        self.assertGreater(int(again[1]), 0)


if __name__ == "__main__":
    unittest.main()
