#!/bin/sh
# campaigns/slurm.sh FOLDER COMMAND…: runs a command beside a Slurm cluster of this machine alone, whose
# files are in FOLDER, and ends the cluster with it. For tests: needs Debian's packages slurmctld, slurmd,
# slurm-client and munge, and root.
set -eu
folder=$(realpath "$1")
shift
mkdir -p "$folder/state" "$folder/spool"
# Its daemons keep to ports and a socket of their own, beside a cluster that may be here already.
socket=$folder/munge.socket
if [ ! -f "$folder/munge.key" ]; then
    head -c 1024 /dev/urandom >"$folder/munge.key"
    chmod 400 "$folder/munge.key"
fi
host=$(hostname -s)
cat >"$folder/slurm.conf" <<END
ClusterName=alone
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=$socket
CryptoType=crypto/munge
StateSaveLocation=$folder/state
SlurmdSpoolDir=$folder/spool
SlurmctldPidFile=$folder/slurmctld.pid
SlurmdPidFile=$folder/slurmd.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdLogFile=$folder/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
MpiDefault=none
MinJobAge=600
ReturnToService=2
NodeName=$host NodeAddr=127.0.0.1 CPUs=$(nproc) RealMemory=1000 State=UNKNOWN
PartitionName=queue Nodes=$host Default=YES MaxTime=INFINITE State=UP
END
export SLURM_CONF="$folder/slurm.conf"
# Snakemake takes that variable from the steps of a job, which would be right for /etc/slurm/slurm.conf.
mkdir -p "$folder/bin"
printf '#!/bin/sh\nSLURM_CONF=%s exec %s "$@"\n' "$SLURM_CONF" "$(command -v srun)" >"$folder/bin/srun"
chmod +x "$folder/bin/srun"
export PATH="$folder/bin:$PATH"

started=
# Only what was started here is ended.
# shellcheck disable=SC2086
trap 'kill $started 2>/dev/null; wait' EXIT
munged --foreground --force --socket="$socket" --key-file="$folder/munge.key" \
    --pid-file="$folder/munged.pid" --log-file="$folder/munged.log" --seed-file="$folder/munged.seed" \
    >"$folder/munged.out" 2>&1 &
started=$!
slurmctld -D >"$folder/slurmctld.out" 2>&1 &
started="$started $!"
slurmd -D >"$folder/slurmd.out" 2>&1 &
started="$started $!"
tries=0
until [ "$(sinfo --noheader --format=%T 2>/dev/null)" = idle ]; do
    tries=$((tries + 1))
    if [ $tries -gt 60 ]; then
        echo "the cluster does not come up; its logs are in $folder" >&2
        tail -n 5 "$folder"/*.log "$folder"/*.out >&2
        exit 1
    fi
    sleep 0.5
done
"$@"
