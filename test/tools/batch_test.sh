#!/usr/bin/env bash
# Batches in shards, resumed, merged, under GNU parallel, over ssh and as a Slurm array would:
#   batch_test.sh BIN_DIR SOURCE_DIR
# Every way must give the same lines as one run in one thread.
set -euo pipefail
bin=$1 source=$2
work=$(mktemp -d)
server=''
finish() {
  [ -z "$server" ] || kill "$server" 2>/dev/null || true
  rm -rf "$work"
}
trap finish EXIT
cd "$work"
fail() { echo "batch_test: $1" >&2; exit 1; }
config=$source/config/paper_simulation.yaml
items=(--config "$config" --set run/duration=4 --count 7)

"$bin/monte_carlo" "${items[@]}" --threads 1 --output one.jsonl >one.txt
[ "$(wc -l <one.jsonl)" -eq 7 ] || fail "not one line per item"
grep -q 'items      7, 0 refused' one.txt || fail "no statistics: $(cat one.txt)"

for shard in 0 1 2; do
  "$bin/monte_carlo" "${items[@]}" --shard $shard/3 --output shard_$shard.jsonl >/dev/null
done
"$bin/monte_carlo" --merge shard_2.jsonl shard_0.jsonl shard_1.jsonl shard_0.jsonl --output merged.jsonl >merged.txt
cmp one.jsonl merged.jsonl || fail "shards give other lines"
cmp one.txt merged.txt || fail "shards give other statistics"

# Cut short in the middle of a line.
head -c "$(($(head -n 4 one.jsonl | wc -c) - 30))" one.jsonl >cut.jsonl
! "$bin/monte_carlo" "${items[@]}" --output cut.jsonl 2>refusal.txt || fail "overwrote a file"
grep -q 'add --resume' refusal.txt || fail "$(cat refusal.txt)"
"$bin/monte_carlo" "${items[@]}" --output cut.jsonl --resume >/dev/null
"$bin/monte_carlo" --merge cut.jsonl --output resumed.jsonl >/dev/null
cmp one.jsonl resumed.jsonl || fail "resumed run gives other lines"
! "$bin/monte_carlo" "${items[@]}" --set run/seed=5 --output cut.jsonl --resume 2>refusal.txt ||
  fail "mixed two configurations"
grep -q 'another configuration' refusal.txt || fail "$(cat refusal.txt)"

# A cluster, one task after the other.
for task in 0 1; do
  SLURM_ARRAY_TASK_ID=$task SLURM_ARRAY_TASK_COUNT=2 SLURM_CPUS_PER_TASK=1 \
    RING_GYRO_MONTE_CARLO=$bin/monte_carlo bash "$source/scripts/monte_carlo.slurm" "$config" 7 slurm \
    --set run/duration=4 >/dev/null
done
"$bin/monte_carlo" --merge slurm/*.jsonl --output slurm.jsonl >/dev/null
cmp one.jsonl slurm.jsonl || fail "array gives other lines"

# Bags.
for seed in 1 2 3; do
  "$bin/simulate" --config "$config" --duration 4 --seed $seed --output $seed.bag >/dev/null
done
echo 'no bag' >4.bag
bags=(--config "$config" 1.bag 2.bag 3.bag 4.bag)
! "$bin/identify_batch" "${bags[@]}" --output bags.jsonl >/dev/null || fail "took a file that is no bag"
[ "$(grep -c '"result"' bags.jsonl)" -eq 3 ] || fail "not three results"
[ "$(grep -c '"refused"' bags.jsonl)" -eq 1 ] || fail "not one refusal"
"$bin/identify_batch" "${bags[@]}" --shard 0/2 --output even.jsonl >/dev/null
! "$bin/identify_batch" "${bags[@]}" --shard 1/2 --output odd.jsonl >/dev/null || fail "took a file that is no bag"
"$bin/identify_batch" --merge bags.jsonl --output sorted.jsonl >/dev/null
"$bin/identify_batch" --merge odd.jsonl even.jsonl --output joined.jsonl >/dev/null
cmp sorted.jsonl joined.jsonl || fail "shards of bags give other lines"
"$bin/identify_batch" "${bags[@]}" --output bags.jsonl --resume | grep -q '0 done, 0 refused, 4 were' ||
  fail "did bags again"

if ! command -v parallel >/dev/null || ! parallel --version 2>/dev/null | grep -q GNU; then
  echo "batch_test: GNU parallel is not installed: not tested"
  exit 0
fi
export PARALLEL_HOME=$work/.parallel
mkdir -p "$PARALLEL_HOME"
touch "$PARALLEL_HOME/will-cite"
parallel -j 2 "$bin/monte_carlo" "${items[@]}" --shard {}/4 --threads 1 --output parallel_{}.jsonl \
  ::: 0 1 2 3 >/dev/null
"$bin/monte_carlo" --merge parallel_*.jsonl --output parallel.jsonl >/dev/null
cmp one.jsonl parallel.jsonl || fail "GNU parallel gives other lines"

# A server of its own: own port, host key, configuration and user key.
sshd=$(command -v sshd || true)
if [ -z "$sshd" ]; then
  echo "batch_test: openssh-server is not installed: ssh is not tested"
  exit 0
fi
ssh-keygen -q -t ed25519 -N '' -f host_key
ssh-keygen -q -t ed25519 -N '' -f user_key
port=$("$source/scripts/free_ports.py")
cat >sshd_config <<END
Port $port
ListenAddress 127.0.0.1
HostKey $work/host_key
PidFile $work/sshd.pid
AuthorizedKeysFile $work/user_key.pub
StrictModes no
UsePAM no
PermitRootLogin prohibit-password
PasswordAuthentication no
END
[ "$(id -u)" -ne 0 ] || mkdir -p /run/sshd
"$sshd" -D -f "$work/sshd_config" -E "$work/sshd.log" &
server=$!
cat >ssh_config <<END
Host loopback
  HostName 127.0.0.1
  Port $port
  IdentityFile $work/user_key
  IdentitiesOnly yes
  StrictHostKeyChecking no
  UserKnownHostsFile $work/known_hosts
  LogLevel ERROR
END
for _ in $(seq 50); do
  ssh -F ssh_config loopback true 2>ssh.txt && break
  kill -0 "$server" 2>/dev/null || { echo "batch_test: sshd does not run here ($(tail -n 1 sshd.log)): ssh is not tested"; exit 0; }
  sleep 0.1
done
ssh -F ssh_config loopback true || fail "no login over loopback: $(cat ssh.txt sshd.log)"
# Without rsync nothing can be brought back: then the folder is taken for a shared one.
back=(--workdir "$work/remote" --return {}.ssh.jsonl --cleanup)
command -v rsync >/dev/null || back=(--workdir "$work")
parallel --sshlogin "ssh -F $work/ssh_config loopback" -j 2 "${back[@]}" \
  "$bin/monte_carlo" "${items[@]}" --shard {}/2 --threads 1 --output {}.ssh.jsonl ::: 0 1 >/dev/null
"$bin/monte_carlo" --merge 0.ssh.jsonl 1.ssh.jsonl --output ssh.jsonl >/dev/null
cmp one.jsonl ssh.jsonl || fail "over ssh it gives other lines"
echo "batch_test: shards, resume, merge, Slurm array, bags, GNU parallel, ssh"
