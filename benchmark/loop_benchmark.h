#pragma once

#include <benchmark/benchmark.h>

#include <string>

namespace cvg {

/// Our plant against Boost.odeint's fehlberg78 with one step per sample, while drive, frequency and
/// conditions change in every block; time per block. Further counters: our_error and peer_error,
/// the largest difference of a displacement from a long double solution, relative to the amplitude.
void plantAgainstOdeint(benchmark::State& state);

/// Plant, noise, demodulation and loops against PlainLoop; time per block. Further counter:
/// speed, simulated time over processor time.
void loopAgainstPlain(benchmark::State& state, const std::string& configuration_file);

/// The whole chain with compensation and this period of the identifier [s] against plant and loops
/// alone; time per block. The ratio is below one.
void chainAgainstLoop(benchmark::State& state, const std::string& configuration_file,
                      double period);

/// A loop that has run for `age` [s] against a new one; time per block.
void oldAgainstYoung(benchmark::State& state, const std::string& configuration_file, double age);

/// A batch of closed-loop runs on two threads against one; wall time per run.
void twoCoresAgainstOne(benchmark::State& state, const std::string& configuration_file);

}  // namespace cvg
