#!/usr/bin/env bash
# SPDX-License-Identifier: BSD-3-Clause
# A sweep as a job array of Slurm: one run for each task, as long as it takes, in pieces of --time. Submit it from the directory that
# shall hold the results:
#     sbatch --array=0-8 PATH/slurm.sh
# Five minutes before the time is over Slurm sends SIGUSR1 to this script: the run writes a checkpoint and leaves, the task is put
# back in line, and goes on later, on whichever machine. Preemption sends SIGTERM: Slurm itself puts the task back then.
#SBATCH --job-name=meniscus
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=4
#SBATCH --time=04:00:00
#SBATCH --signal=B:USR1@300
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=%x-%A_%a.log
set -u
case=${CASE:-hydrostatic}
read -ra resolutions <<<"${RESOLUTIONS:-20 30 40}"
read -ra schemes <<<"${SCHEMES:-riemann dissipation interfacial}"
read -ra settings <<<"${SETTINGS:-}"
# Slurm runs a copy of this script, which cannot tell where the others are: below the prefix of the program, if it was installed.
program=$(readlink -f "$(command -v "${MENISCUS:-meniscus}")")
workflows=${MENISCUS_WORKFLOWS:-$(dirname "$program")/../share/meniscus/workflows}
if [ ! -f "$workflows/until_done.py" ]; then
    echo "slurm.sh: no until_done.py in $workflows: have meniscus in the PATH of the job, or name the folder in MENISCUS_WORKFLOWS" >&2
    exit 2
fi

runs=$((${#resolutions[@]} * ${#schemes[@]}))
task=${SLURM_ARRAY_TASK_ID:-$runs}
if [ "$task" -ge "$runs" ]; then
    echo "slurm.sh: submit it with --array=0-$((runs - 1))" >&2
    exit 2
fi
resolution=${resolutions[task % ${#resolutions[@]}]}
scheme=${schemes[task / ${#resolutions[@]}]}
name=scheme~$scheme/resolution~$resolution
more=()
for setting in "${settings[@]}"; do more+=(--set "$setting"); done

# The shell does not run traps while it waits for a command in the foreground.
late='' job=''
trap 'late=yes; [ -z "$job" ] || kill -TERM "$job"' USR1
trap '[ -z "$job" ] || kill -TERM "$job"' TERM
/usr/bin/python3 "$workflows/until_done.py" --accept 70 "$name.json" "$name.run" "$case" --set "resolution=$resolution" \
    --set "scheme={$scheme: {}}" --set "threads=${SLURM_CPUS_PER_TASK:-1}" "${more[@]}" &
job=$!
# A signal ends `wait`, not the job; once that is gone, the shell still knows how it ended.
while kill -0 "$job" 2>/dev/null; do wait "$job"; done
wait "$job"
code=$?
echo "$name: exit code $code"
if [ "$code" -eq 75 ] && [ -n "$late" ]; then exec scontrol requeue "${SLURM_JOB_ID:?}"; fi
exit "$code"
