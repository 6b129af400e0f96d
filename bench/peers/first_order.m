% One bent whisker in Octave: a first-order march from the contact to the base, as MATLAB tools do it.
% The method follows the published description of elastica2D; the code is ours. Prints a line for bench/report.py.
1;

function [x, y] = first_order(force, s_a, ei, nodes)
  h = s_a / (nodes - 1);
  along = 0; across = 0; u = 0;
  for k = 1:nodes - 1
    bend = force * along / ei * h;
    along = along + h * cos(u);
    across = across + h * sin(u);
    u = u + bend;
  end
  x = along * cos(u) + across * sin(u);
  y = along * sin(u) - across * cos(u);
end

% The exact contact point comes from the caller.
exact = [str2double(getenv("EXACT_X")), str2double(getenv("EXACT_Y"))];
ei = 2.8886e-4; len = 0.075;
times = zeros(1, 7);
for k = 1:7
  begin = cputime();
  for j = 1:10
    [x, y] = first_order(0.25, 0.06, ei, 101);
  end
  times(k) = (cputime() - begin) / 10;
end
printf("row\tOne bent whisker (normal load of 0.25 N at 60 mm of 75 mm)\tOctave %s, first-order march, 101 nodes\t%.6g\t%.6g\t%.6g\tcontact off by %.1e of the length\n", ...
       version(), median(times), min(times), max(times), hypot(x - exact(1), y - exact(2)) / len);
