#pragma once

#include <benchmark/benchmark.h>
#include <time.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <vector>

namespace cvg {

/// Processor time of the calling thread [s]; other work on the machine does not count.
inline double threadTime() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

/// Wall time [s], for work of several threads.
inline double wallTime() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

inline double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Times two pieces of work, ours and a peer's, once each per iteration of `state`, so that other
/// work on the machine affects both in the same way. The order alternates. Counters: ratio (median
/// over the turns of the peer's time per item over ours), ours and peer (medians, s per item).
template <typename Clock, typename Ours, typename Peer>
void timeInTurns(benchmark::State& state, Clock clock, double our_items, Ours ours,
                 double peer_items, Peer peer) {
  std::vector<double> our_times;
  std::vector<double> peer_times;
  std::vector<double> ratios;
  const auto time = [&clock](auto& work) {
    const double begin = clock();
    work();
    return clock() - begin;
  };
  // One turn is not counted, so that caches and clock frequency settle.
  ours();
  peer();
  bool ours_first = true;
  for (auto _ : state) {
    double our_time = 0.0;
    double peer_time = 0.0;
    if (ours_first) our_time = time(ours);
    peer_time = time(peer);
    if (!ours_first) our_time = time(ours);
    ours_first = !ours_first;
    state.SetIterationTime(our_time);
    our_times.push_back(our_time / our_items);
    peer_times.push_back(peer_time / peer_items);
    ratios.push_back(peer_times.back() / our_times.back());
  }
  state.counters["ours"] = median(our_times);
  state.counters["peer"] = median(peer_times);
  state.counters["ratio"] = median(ratios);
}

}  // namespace cvg
