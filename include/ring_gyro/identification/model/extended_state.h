#pragma once

#include <Eigen/Core>
#include <complex>
#include <optional>
#include <string>
#include <vector>

#include "ring_gyro/common/device_knowledge.h"
#include "ring_gyro/identification/model/extended_parameters.h"

namespace cvg {

constexpr int kMostExtendedStates = 64;
/// Size chosen at run time, stored inside the object: no allocation.
using ExtendedVector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostExtendedStates, 1>;
using ExtendedMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostExtendedStates,
                                     kMostExtendedStates>;

/// The states that the chosen groups of ExtendedParameters give, and their meaning.
///
/// A state has two sets of coordinates. Physical coordinates are for people, one for each name. In
/// linear coordinates the rate of the envelope is linear in every parameter: xi0 w0 gamma replaces
/// gamma, and the entries of ks times the drive matrix replace ks, phase and mismatch. The filter
/// uses linear coordinates, so a poor first guess of ks or Q does no harm.
class ExtendedState {
 public:
  /// Throws std::invalid_argument, naming what cannot be used or cannot be told apart.
  ExtendedState(const DeviceKnowledge& device, const ExtendedParameters& parameters);

  /// Envelope first (re_x, im_x, re_y, im_y), then the parameters.
  const std::vector<std::string>& names() const { return names_; }
  Eigen::Index size() const { return static_cast<Eigen::Index>(names_.size()); }
  std::optional<Eigen::Index> find(const std::string& name) const;

  ExtendedVector physical(const ExtendedVector& linear) const;
  ExtendedVector linear(const ExtendedVector& physical) const;
  /// Derivative of the physical with respect to the linear coordinates.
  ExtendedMatrix physicalByLinear(const ExtendedVector& linear) const;
  /// Derivative of the linear with respect to the physical coordinates.
  ExtendedMatrix linearByPhysical(const ExtendedVector& physical) const;

  /// First index of each group in the vector; -1: not estimated. Each harmonic has its cosine, then
  /// its sine.
  struct Layout {
    int gamma = 4;  // gamma1, gamma2
    int mu = 6;     // mu1, mu2
    int drive_gain = 8;
    int decay_rate = -1;
    int frequency = -1;
    int drive_phase = -1;
    int mismatch = -1;        // gain mismatch, gain skew, phase mismatch, phase skew
    int drive_rotation = -1;  // turn, phase of the turn
    int drift_bias = -1;      // drift, quadrature
    int even_harmonics = -1;
    int odd_harmonics = -1;
    int sense_mismatch = -1;  // as mismatch
    int rotation_scale = -1;
    int pickoff_cubic = -1;
    int rotation_rate = -1;
  };
  const Layout& layout() const { return layout_; }
  const std::vector<int>& evenOrders() const { return even_orders_; }
  const std::vector<int>& oddOrders() const { return odd_orders_; }
  /// f0 and Q: where their estimates start, or their values if they are not estimated.
  const DeviceKnowledge& device() const { return device_; }
  double decayRate(const ExtendedVector& linear) const;                ///< xi0 w0 [1/s]
  double angularFrequency(const ExtendedVector& linear) const;         ///< w0 [rad/s]
  std::complex<double> driveGain(const ExtendedVector& linear) const;  ///< ks e^{-ip} [1/s^2]

 private:
  // Indices of the real and the imaginary part of an entry of the drive matrix.
  struct Entry {
    int real;
    int imaginary;
  };

  std::vector<std::string> names_;
  std::vector<Entry> entries_;
  Layout layout_;
  std::vector<int> even_orders_;
  std::vector<int> odd_orders_;
  DeviceKnowledge device_;
};

}  // namespace cvg
