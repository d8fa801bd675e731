#pragma once

#include <benchmark/benchmark.h>

#include <string>

namespace cvg {

/// Plant under drive, frequency and conditions that change every block against one step of
/// Boost.odeint's fehlberg78 a sample; time per block. Further counters: our_error, peer_error,
/// largest difference of a displacement from a long double solution, relative to the amplitude.
void plantAgainstOdeint(benchmark::State& state);

/// Plant, noise, demodulation and loops against PlainLoop; time per block. Further counter:
/// speed, simulated time over processor time.
void loopAgainstPlain(benchmark::State& state, const std::string& configuration_file);

/// The whole chain with compensation, with this period of the identifier [s], against plant and
/// loops alone; time per block. The ratio is below one.
void chainAgainstLoop(benchmark::State& state, const std::string& configuration_file,
                      double period);

/// A loop that has run for `age` [s] against a young one; time per block.
void oldAgainstYoung(benchmark::State& state, const std::string& configuration_file, double age);

/// A batch of closed-loop runs on two threads against one, wall time per run.
void twoCoresAgainstOne(benchmark::State& state, const std::string& configuration_file);

}  // namespace cvg
