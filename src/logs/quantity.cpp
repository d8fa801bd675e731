#include "ring_gyro/logs/quantity.h"

#include <boost/algorithm/string/predicate.hpp>
#include <cctype>

#include "ring_gyro/common/angle.h"

namespace cvg {
namespace {

// Possible values of a quantity. Doubles resolve a stamp of 2^32 s to 1e-6 s and an angle of 1e8
// rad (years of turning) to 1e-8 rad; a pick-off saturates far below 1 kV; no gain is above 10 kV
// of drive for the smallest motion that is worth logging (1e-3 V, 1.6 kHz). Readers of the bag
// refuse values of 1e12 or more.
constexpr Range kTimes = Range::between(-4294967295.0, 4294967295.0);
constexpr Range kMotion = Range::between(-1e3, 1e3);
constexpr Range kAngles = Range::between(-1e8, 1e8);
constexpr Range kReferencePhases = Range::between(-1e11, 1e11);  // unwrapped over a long log
constexpr Range kFrequencies = Range::between(0.0, kTwoPi * 20e6);
constexpr Range kVelocityGains = Range::between(-1e3, 1e3);
constexpr Range kDisplacementGains = Range::between(-1e7, 1e7);
constexpr Range kRates = Range::between(-1e4, 1e4);
constexpr Range kDrive = Range::between(-1e4, 1e4);
constexpr Range kDelays = Range::between(0.0, 100.0);
constexpr Range kFlags = Range::between(0.0, 1.0);
constexpr Range kSequences = Range::between(0.0, 9e15);

constexpr std::array<QuantityInfo, kQuantityCount> kQuantities = {{
    {Quantity::kTime, "t", Dimension::kTime, "time", kTimes,
     " t time timestamp elapsed elapsedtime zeit temps "},
    {Quantity::kA, "a", Dimension::kVoltage, "major semi-axis", kMotion,
     " a amp amplitude major majoraxis semimajor semimajoraxis orbita "},
    {Quantity::kB, "b", Dimension::kVoltage, "minor semi-axis", kMotion,
     " b quad quadrature minor minoraxis semiminor semiminoraxis orbitb quadratureamplitude "},
    {Quantity::kTheta, "theta", Dimension::kAngle, "pattern angle", kAngles,
     " theta angle patternangle precessionangle vibrationangle standingwaveangle winkel "},
    {Quantity::kPhi, "phi", Dimension::kAngle, "phase against the reference", kAngles,
     " phi phase orbitphase pllphase "},
    {Quantity::kOmega, "omega", Dimension::kAngularRate, "reference frequency", kFrequencies,
     " omega w f freq frequency fref fnco nco ncofrequency referencefrequency pllfrequency "
     "omegaref "
     "wref drivefrequency "},
    {Quantity::kBeta, "beta", Dimension::kTime, "sustain gain", kVelocityGains,
     " beta sustain sustaingain energygain betagain gainbeta "},
    {Quantity::kAlpha, "alpha", Dimension::kNone, "quadrature gain", kDisplacementGains,
     " alpha quadgain quadraturegain alphagain gainalpha "},
    {Quantity::kVirtualRate, "virtual_rate", Dimension::kAngularRate,
     "steering, as a rotation of this rate", kRates,
     " virtualrate virtualrotation steeringrate steerrate steering steer omegas "},
    {Quantity::kCompensationGain1, "compensation_gain1", Dimension::kTime, "compensation g1",
     kVelocityGains, " compensationgain1 g1 "},
    {Quantity::kCompensationGain2, "compensation_gain2", Dimension::kTime, "compensation g2",
     kVelocityGains, " compensationgain2 g2 "},
    {Quantity::kSustainVolts, "sustain_volts", Dimension::kVoltage, "sustain drive, w beta a",
     kDrive, " sustainvolts sustainvoltage sustaindrive sustainforce agc agcoutput energydrive "},
    {Quantity::kQuadratureVolts, "quadrature_volts", Dimension::kVoltage,
     "quadrature drive, alpha a", kDrive,
     " quadraturevolts quadraturevoltage quadraturedrive quadratureforce quaddrive "},
    {Quantity::kSteeringVolts, "steering_volts", Dimension::kVoltage,
     "steering drive, across the pattern", kDrive,
     " steeringvolts steeringvoltage steeringdrive steeringforce steerdrive "},
    {Quantity::kDriveXReal, "drive_x_real", Dimension::kVoltage, "total drive envelope", kDrive,
     " drivexreal drivexre fxre fxreal fxcos "},
    {Quantity::kDriveXImag, "drive_x_imag", Dimension::kVoltage, "total drive envelope", kDrive,
     " driveximag drivexim fxim fximag "},
    {Quantity::kDriveYReal, "drive_y_real", Dimension::kVoltage, "total drive envelope", kDrive,
     " driveyreal driveyre fyre fyreal fycos "},
    {Quantity::kDriveYImag, "drive_y_imag", Dimension::kVoltage, "total drive envelope", kDrive,
     " driveyimag driveyim fyim fyimag "},
    {Quantity::kCx, "cx", Dimension::kVoltage, "x in phase with cos", kMotion,
     " cx xc xcos xi ix "},
    {Quantity::kSx, "sx", Dimension::kVoltage, "x in phase with sin", kMotion,
     " sx xs xsin xq qx "},
    {Quantity::kCy, "cy", Dimension::kVoltage, "y in phase with cos", kMotion,
     " cy yc ycos yi iy "},
    {Quantity::kSy, "sy", Dimension::kVoltage, "y in phase with sin", kMotion,
     " sy ys ysin yq qy "},
    {Quantity::kX, "x", Dimension::kVoltage, "displacement sample", kMotion,
     " x sensex xsense displacementx xdisplacement "},
    {Quantity::kY, "y", Dimension::kVoltage, "displacement sample", kMotion,
     " y sensey ysense displacementy ydisplacement "},
    {Quantity::kReferencePhase, "psi", Dimension::kAngle, "phase of the reference",
     kReferencePhases, " psi referencephase ncophase "},
    {Quantity::kGroupDelay, "group_delay", Dimension::kTime, "of the demodulation", kDelays,
     " groupdelay delay "},
    {Quantity::kUsable, "usable", Dimension::kNone, "1: locked and without fault", kFlags,
     " usable valid locked "},
    {Quantity::kSequence, "sequence", Dimension::kNone, "number of the block", kSequences,
     " sequence seq "},
}};

}  // namespace

const std::array<QuantityInfo, kQuantityCount>& quantities() { return kQuantities; }

const QuantityInfo& infoOf(Quantity quantity) { return kQuantities[indexOf(quantity)]; }

std::optional<Quantity> quantityFromName(std::string_view name) {
  for (const QuantityInfo& info : kQuantities) {
    if (boost::iequals(name, info.name)) return info.quantity;
  }
  return std::nullopt;
}

std::optional<Quantity> guessQuantity(std::string_view word) {
  std::string plain = " ";
  for (const char c : word) {
    const auto byte = static_cast<unsigned char>(c);
    if (std::isalnum(byte) != 0) plain += static_cast<char>(std::tolower(byte));
  }
  plain += ' ';
  if (plain.size() < 3) return std::nullopt;
  for (const QuantityInfo& info : kQuantities) {
    if (std::string_view(info.synonyms).find(plain) != std::string_view::npos) return info.quantity;
  }
  return std::nullopt;
}

}  // namespace cvg
