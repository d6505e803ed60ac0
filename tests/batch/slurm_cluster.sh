#!/bin/bash
# Runs a real Slurm on this machine for tests: munged, slurmctld and two slurmd (n1, n2) on the
# loopback interface.
# usage: eval "$(slurm_cluster.sh start DIR)"   start, wait until both nodes are idle, print exports
#        slurm_cluster.sh stop DIR              stop everything that was started from DIR
#        slurm_cluster.sh status DIR            what runs
#        slurm_cluster.sh node-kill DIR n1      lose a node: SIGKILL to its slurmd and all it runs
#        slurm_cluster.sh node-start DIR n1     bring it back
# Needs slurmctld slurmd slurm-client munge (Debian: slurm-wlm). NODE_CPUS=4, NODE_MEM=4000 (MB): what
# a node pretends to have.
set -euo pipefail
export PATH=$PATH:/usr/sbin:/sbin
NODES="n1 n2"

say() { echo "slurm_cluster.sh: $*" >&2; }
die() { say "$*"; exit 1; }
usage() { sed -n '2,10s/^# //p' "$0" >&2; exit 2; }

# alive FILE NAME: is the pid in FILE a living process called NAME (never trust a stale pid file)
alive() {
    local pid
    [[ -s $1 ]] || return 1
    pid=$(cat "$1" 2>/dev/null || true); pid=${pid//[^0-9]/}
    [[ -n $pid && $(cat "/proc/$pid/comm" 2>/dev/null) == "$2" ]] || return 1
    [[ $(awk '{print $3}' "/proc/$pid/stat" 2>/dev/null) != Z ]]
}

free_port() {  # first port from $1 up that no process listens on; stays below the ephemeral range
    local p=$1
    while (exec 3<>"/dev/tcp/127.0.0.1/$p") 2>/dev/null; do p=$((p + 1)); done
    echo "$p"
}

write_conf() {
    local me host p0 p1 p2
    me=$(id -un) host=$(hostname -s)
    p0=$(free_port $((20000 + RANDOM % 10000)))
    p1=$(free_port $((p0 + 1))) p2=$(free_port $((p0 + 2)))
    [[ $p2 -gt $p1 ]] || p2=$((p1 + 1))
    cat >"$D/slurm.conf" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=$p0
SlurmUser=$me
SlurmdUser=$me
# listen on loopback only
CommunicationParameters=NoCtldInAddrAny,NoInAddrAny
AuthType=auth/munge
CredType=cred/munge
# cred_expire also sets how long a requeued job waits before it may start again (default 120 s!)
AuthInfo=socket=$D/munge/munge.sock,cred_expire=5,ttl=300
StateSaveLocation=$D/state
SlurmdSpoolDir=$D/spool.%n
SlurmctldPidFile=$D/slurmctld.pid
SlurmdPidFile=$D/slurmd.%n.pid
SlurmctldLogFile=$D/slurmctld.log
SlurmdLogFile=$D/slurmd.%n.log
SlurmctldDebug=info
SlurmdDebug=info
# no cgroups; process groups also find orphans
ProctrackType=proctrack/pgid
TaskPlugin=task/none
MpiDefault=none
SwitchType=switch/none
# memory is enforced by sampling only (no cgroup): OverMemoryKill => the step is killed
JobAcctGatherType=jobacct_gather/linux
JobAcctGatherFrequency=task=2
JobAcctGatherParams=OverMemoryKill,UsePss
AccountingStorageType=accounting_storage/none
MailProg=/bin/true
JobCompType=jobcomp/filetxt
JobCompLoc=$D/jobcomp.txt
# finished jobs stay visible to scontrol/squeue for so many seconds
MinJobAge=86400
MaxJobCount=50000
JobRequeue=1
# 1: a node that stopped answering comes back by itself, one set DOWN by hand stays down until State=RESUME
# (2 would bring that one back within a second, as its slurmd still answers)
ReturnToService=1
SlurmdTimeout=10
SlurmctldTimeout=10
KillWait=3
CompleteWait=0
# the time limit is checked every 30 s at best; OverTimeLimit gives no seconds either
OverTimeLimit=0
SchedulerType=sched/backfill
SchedulerParameters=bf_interval=1,sched_interval=1,batch_sched_delay=0,sched_min_interval=0
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
# accept more CPUs and memory than the machine has
SlurmdParameters=config_overrides
GresTypes=gpu
DefMemPerCPU=100
NodeName=n1 NodeHostname=$host NodeAddr=127.0.0.1 Port=$p1 CPUs=$CPUS RealMemory=$MEM Gres=gpu:1 State=UNKNOWN
NodeName=n2 NodeHostname=$host NodeAddr=127.0.0.1 Port=$p2 CPUs=$CPUS RealMemory=$MEM Gres=gpu:1 State=UNKNOWN
PartitionName=main Nodes=n1,n2 Default=YES MaxTime=INFINITE DefaultTime=60 State=UP
CONF
    # a gpu gres without File= is dropped by slurmd 22.05 ("reported lower than configured (0 < 1)"), so name a
    # device file; /dev/null will do, as no cgroup guards it (a plain file works too, with an error line in the log).
    echo "Name=gpu File=/dev/null" >"$D/gres.conf"
}

start_slurmd() { slurmd -N "$1" -f "$SLURM_CONF" </dev/null >>"$D/slurmd.$1.out" 2>&1; }

stop_pid() {  # FILE NAME: TERM, wait up to 10 s, KILL
    local pid
    alive "$1" "$2" || { rm -f "$1"; return 0; }
    pid=$(tr -dc 0-9 2>/dev/null <"$1" || true)
    kill -TERM "$pid" 2>/dev/null || true
    for _ in $(seq 100); do alive "$1" "$2" || break; sleep 0.1; done
    if alive "$1" "$2"; then kill -KILL "$pid" 2>/dev/null || true; fi
    rm -f "$1"
}

# kill_steps [NODE]: kill what jobs left behind (all, or those of one node): slurmstepd outlives slurmd, and without
# cgroups orphans outlive slurmstepd. Ours are known by SLURM_CONF + SLURM_JOB_ID in their environment.
kill_steps() {
    local e pid env hit=()
    for e in /proc/[0-9]*/environ; do
        env=$(tr '\0' '\n' 2>/dev/null <"$e") || continue
        [[ $'\n'$env$'\n' == *$'\n'"SLURM_CONF=$SLURM_CONF"$'\n'* ]] || continue
        pid=${e#/proc/} pid=${pid%/environ}
        if [[ $(cat "/proc/$pid/comm" 2>/dev/null || true) == slurmstepd ]]; then
            # a stepd of node N is the one with a child that says SLURMD_NODENAME=N (or any stepd if all are to go)
            [[ -z ${1:-} ]] || pgrep -P "$pid" | sed 's#.*#/proc/&/environ#' | xargs -r cat 2>/dev/null |
                tr '\0' '\n' | grep -qx "SLURMD_NODENAME=$1" || continue
        else
            [[ $env == *SLURM_JOB_ID=* && $pid != "$$" ]] || continue
            [[ -z ${1:-} || $'\n'$env$'\n' == *$'\n'"SLURMD_NODENAME=$1"$'\n'* ]] || continue
        fi
        hit+=("$pid")
    done
    [[ ${#hit[@]} -eq 0 ]] || kill -KILL "${hit[@]}" 2>/dev/null || true
}

stop_all() {
    local n
    if alive "$D/slurmctld.pid" slurmctld; then  # let Slurm kill the jobs itself first
        timeout 5 scancel --state=PENDING,RUNNING,SUSPENDED --user="$(id -un)" 2>/dev/null || true
        timeout 5 scancel --partition=main 2>/dev/null || true
        for _ in $(seq 60); do
            [[ -z $(timeout 5 squeue -h -t running,completing 2>/dev/null || true) ]] && break
            sleep 0.1
        done
    fi
    for n in $NODES; do stop_pid "$D/slurmd.$n.pid" slurmd; done
    stop_pid "$D/slurmctld.pid" slurmctld
    kill_steps
    stop_pid "$D/munge/munged.pid" munged
}

cmd=${1:-}; [[ -n $cmd ]] || usage
[[ -n ${2:-} ]] || usage
mkdir -p "$2"; D=$(cd "$2" && pwd -P)
[[ ${#D} -le 80 ]] || die "path too long for a unix socket: $D"
CPUS=${NODE_CPUS:-4} MEM=${NODE_MEM:-4000}
export SLURM_CONF=$D/slurm.conf
# an outer Slurm job's variables would confuse the inner one
for v in $(compgen -e SLURM_ | grep -vx SLURM_CONF || true); do unset "$v"; done

case $cmd in
start)
    ! alive "$D/slurmctld.pid" slurmctld || die "already running in $D"
    mkdir -p "$D/state" "$D/spool.n1" "$D/spool.n2" "$D/munge"
    chmod 755 "$D" "$D/munge"; chmod 700 "$D/state"
    [[ -f $D/slurm.conf ]] || write_conf
    trap 'say "start failed, logs in $D"; tail -n 5 "$D"/*.log "$D"/*.out >&2 || true; stop_all' ERR
    if [[ ! -f $D/munge/munge.key ]]; then (umask 077; head -c 128 /dev/urandom >"$D/munge/munge.key"); fi
    # --force: do not insist on the ownership of every parent of a temporary folder
    munged --force --socket="$D/munge/munge.sock" --key-file="$D/munge/munge.key" --pid-file="$D/munge/munged.pid" \
        --seed-file="$D/munge/munged.seed" --log-file="$D/munge/munged.log" >&2 2>"$D/munge/munged.out"
    slurmctld -f "$SLURM_CONF" </dev/null >>"$D/slurmctld.out" 2>&1
    for n in $NODES; do start_slurmd "$n"; done
    t0=$SECONDS
    until [[ $(timeout 5 sinfo -h -N -o %t 2>/dev/null | sort | uniq -c | tr -s ' ') == " 2 idle" ]]; do
        # after a restart with old state a node may be left down or drained by an experiment
        timeout 5 scontrol update NodeName=n1,n2 State=RESUME >/dev/null 2>&1 || true
        [[ $((SECONDS - t0)) -lt 120 ]] || { say "nodes not idle in time"; sinfo -N -l >&2 || true; false; }
        sleep 0.2
    done
    trap - ERR
    say "up after $((SECONDS)) s in $D"
    echo "export SLURM_CONF=$SLURM_CONF"
    ;;
stop) stop_all; say "stopped $D" ;;
status)
    for f in munge/munged.pid:munged slurmctld.pid:slurmctld slurmd.n1.pid:slurmd slurmd.n2.pid:slurmd; do
        if alive "$D/${f%:*}" "${f#*:}"; then echo "$f up ($(tr -dc 0-9 <"$D/${f%:*}"))"; else echo "$f down"; fi
    done
    timeout 5 sinfo -N -l || true; timeout 5 squeue || true
    ;;
node-kill)
    alive "$D/slurmd.$3.pid" slurmd || die "slurmd $3 is not running"
    kill -KILL "$(tr -dc 0-9 <"$D/slurmd.$3.pid")"; rm -f "$D/slurmd.$3.pid"
    kill_steps "$3"
    ;;
node-start) start_slurmd "$3" ;;
*) usage ;;
esac
