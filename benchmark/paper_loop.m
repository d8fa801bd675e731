% The paper's loop written in the usual way for Octave: extended Kalman filter on the averaged model,
% equations (1)-(5) and (29)-(33), seven states, one step per millisecond. Prints the time per step.
%   octave-cli paper_loop.m STEPS
1;
steps = str2double(argv(){1});
f0 = 14e3; Q = 22000; w0 = 2 * pi * f0; d = w0 / (2 * Q); w = w0; h = 1e-3;
truth = [0.02; 0.03; -30e-6; -40e-6; 1.1e5];
rate = 12 * pi / 180; noise = 5e-6 / sqrt(h);

% Signals of the locked gyroscope in balance: a = 1, b = 0, phi = -pi / 2.
theta = -rate * h * (0:steps - 1);
gamma = truth(1) * cos(2 * theta) + truth(2) * sin(2 * theta);
ms = truth(3) * sin(2 * theta) - truth(4) * cos(2 * theta);
beta = 2 * d * (1 + gamma) / truth(5);
alpha = -w0 * w * ms / truth(5);
a = 1 + noise * randn(1, steps);
b = noise * randn(1, steps);

x = [1; 0; 0; 0; -25e-6; -45e-6; 1.05e5];
P = diag([1e-3, 1e-3, 0.05, 0.05, 1e-5, 1e-5, 1e4] .^ 2);
Qn = diag([2e-6, 2e-6, 0, 0, 0, 0, 0] .^ 2 * h);
R = noise ^ 2 * eye(2);
H = [eye(2), zeros(2, 5)];
begin = tic;
for n = 1:steps
  s = sin(2 * theta(n)); c = cos(2 * theta(n));
  g = x(3) * c + x(4) * s; m = x(5) * s - x(6) * c; ks = x(7);
  fa = a(n) * beta(n) / 2 - b(n) * alpha(n) / (2 * w);
  fb = b(n) * beta(n) / 2 - a(n) * alpha(n) / (2 * w);
  f = [-x(1) * d * (1 + g) - x(2) * w0 * m / 2 + ks * fa;
       -x(2) * d * (1 - g) + x(1) * w0 * m / 2 + ks * fb];
  F = eye(7);
  F(1:2, :) += h * [-d * (1 + g), -w0 * m / 2, -x(1) * d * c, -x(1) * d * s, ...
                    -x(2) * w0 * s / 2, x(2) * w0 * c / 2, fa;
                    w0 * m / 2, -d * (1 - g), x(2) * d * c, x(2) * d * s, ...
                    x(1) * w0 * s / 2, -x(1) * w0 * c / 2, fb];
  x(1:2) += h * f;
  P = F * P * F' + Qn;
  S = H * P * H' + R;
  K = P * H' / S;
  x += K * ([a(n); b(n)] - H * x);
  J = eye(7) - K * H;
  P = J * P * J' + K * R * K';
end
printf("%.6e %.6f %.6f\n", toc(begin) / steps, x(3), x(4));
