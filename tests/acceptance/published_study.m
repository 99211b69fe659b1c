% The published Pixel study's arithmetic on raw frames in one binary file, for comparison: octave published_study.m JOB
% JOB is a folder with job.m (sizes, exposures, positions of the colours) and frames.bin (uint16, one row after another).
% fit, imcrop, std2, mean2 and im2double of the original are written out below.
1;

function img = next_frame(fid, rows, columns)
  img = uint16(fread(fid, [columns rows], 'uint16')');
end

function [R, G1, G2, B] = planes_of(img, at)
  R  = img(at.R(1):2:end,  at.R(2):2:end);
  G1 = img(at.G1(1):2:end, at.G1(2):2:end);
  G2 = img(at.G2(1):2:end, at.G2(2):2:end);
  B  = img(at.B(1):2:end,  at.B(2):2:end);
end

function [R, G, B] = split_channels(img, at)
  [R, G1, G2, B] = planes_of(img, at);
  G = (G1 + G2) ./ 2;
end

function part = imcrop(img, rect)
  part = img(rect(2):rect(2) + rect(4), rect(1):rect(1) + rect(3));
end

function s = std2(img)
  s = std(img(:));
end

function m = mean2(img)
  m = mean(double(img(:)));
end

function n = odd(n)
  n = floor(n);
  if mod(n, 2) == 0
    n = n + 1;
  end
end

function put(list, fid, name, values)
  fprintf(list, '%s %d %d\n', name, size(values, 1), size(values, 2));
  fwrite(fid, values', 'double');
end

function [slopes, intercepts] = per_pixel(x, stack, literally)
  [count, rows, columns] = size(stack);
  if literally
    slopes = zeros(rows, columns);
    intercepts = zeros(rows, columns);
    for i = 1:rows
      for j = 1:columns
        coeff = polyfit(x, stack(:, i, j), 1);
        slopes(i, j) = coeff(1);
        intercepts(i, j) = coeff(2);
      end
    end
  else
    coeff = [x ones(count, 1)] \ reshape(stack, count, rows * columns);
    slopes = reshape(coeff(1, :), rows, columns);
    intercepts = reshape(coeff(2, :), rows, columns);
  end
end

function row = each_channel(img, at, measure)
  [r, g, b] = split_channels(img, at);
  row = [measure(img) measure(r) measure(g) measure(b)];
end

function put_maps(list, out, folder, prefix, slopes, intercepts, at)
  [slopes_r, slopes_g, slopes_b] = split_channels(slopes, at);
  [intercepts_r, intercepts_g, intercepts_b] = split_channels(intercepts, at);
  put(list, out, [folder prefix 'px_resp_all_px.csv'], slopes);
  put(list, out, [folder prefix 'px_resp_r.csv'], slopes_r);
  put(list, out, [folder prefix 'px_resp_g.csv'], slopes_g);
  put(list, out, [folder prefix 'px_resp_b.csv'], slopes_b);
  put(list, out, [folder prefix 'darkv_all_px.csv'], intercepts);
  put(list, out, [folder prefix 'darkv_r.csv'], intercepts_r);
  put(list, out, [folder prefix 'darkv_g.csv'], intercepts_g);
  put(list, out, [folder prefix 'darkv_b.csv'], intercepts_b);
end

job = argv(){end};
source(fullfile(job, 'job.m'));
fid = fopen(fullfile(job, 'frames.bin'), 'r', 'ieee-le');
out = fopen(fullfile(job, 'tables.bin'), 'w', 'ieee-le');
list = fopen(fullfile(job, 'tables.txt'), 'w');

% ---- lens shading: main.m, getMap.m
[mesh_x, mesh_y] = meshgrid(1:rows / 2, 1:columns / 2);
x = mesh_x'(:);
y = mesh_y'(:);
[Q, R6] = qr([ones(size(x)) x y x.^2 x.*y y.^2], 0);
coefficients = zeros(0, 9);
flats = cell(length(isos), length(flat_exposures), flat_frames);
for iso = 1:length(isos)
  for e = 1:length(flat_exposures)
    digitalValue = zeros(rows, columns);
    for j = 1:flat_frames
      flats{iso, e, j} = next_frame(fid, rows, columns);
      digitalValue = digitalValue + double(flats{iso, e, j});
    end
    digitalValue = digitalValue ./ flat_frames;
    [R, G1, G2, B] = planes_of(digitalValue, at);
    fitted = R6 \ (Q' * [R(:) G1(:) G2(:) B(:)]);
    for channel = 1:4
      coefficients(end + 1, :) = [isos(iso) flat_exposures(e) channel fitted(:, channel)'];
    end
    if iso == 1 && e == 1
      surfaces = [ones(size(x)) x y x.^2 x.*y y.^2] * fitted;
      surfaces = surfaces ./ max(surfaces, [], 1);
      map = zeros(rows, columns);
      map(at.R(1):2:end,  at.R(2):2:end)  = reshape(surfaces(:, 1), [rows columns] ./ 2);
      map(at.G1(1):2:end, at.G1(2):2:end) = reshape(surfaces(:, 2), [rows columns] ./ 2);
      map(at.G2(1):2:end, at.G2(2):2:end) = reshape(surfaces(:, 3), [rows columns] ./ 2);
      map(at.B(1):2:end,  at.B(2):2:end)  = reshape(surfaces(:, 4), [rows columns] ./ 2);
    end
  end
end
put(list, out, 'shading_coefficients.csv', coefficients);

% ---- PRNU, DSNU by pixel response
crop = [917 1505 1317 967];
r_coord = [1, floor(968 * 0.2), floor(968 * 0.4), floor(968 * 0.6)];
c_coord = [1, floor(1318 * 0.2), floor(1318 * 0.4), floor(1318 * 0.6)];
edge = 63;
for i = 1:4
  r_coord(i) = odd(r_coord(i));
  c_coord(i) = odd(c_coord(i));
end
if rows < 1505 + 967 || columns < 917 + 1317
  if rows * 4032 < columns * 3024
    scale = @(n) odd(n * rows / 3024);
  else
    scale = @(n) odd(n * columns / 4032);
  end
  crop = arrayfun(scale, crop);
  r_coord = arrayfun(scale, r_coord);
  c_coord = arrayfun(scale, c_coord);
  edge = scale(edge);
end
exposures = flat_exposures';
for iso = 1:length(isos)
  folder = sprintf('iso_%d/', isos(iso));
  stack = zeros(length(exposures), crop(4) + 1, crop(3) + 1);
  for e = 1:length(exposures)
    digitalValueRaw = zeros(rows, columns, flat_frames);
    for j = 1:flat_frames
      digitalValueRaw(:, :, j) = double(flats{iso, e, j}) ./ map;
    end
    stack(e, :, :) = imcrop(mean(digitalValueRaw, 3), crop);
  end
  [slopes, intercepts] = per_pixel(exposures, stack, false);
  put_maps(list, out, folder, '', slopes, intercepts, at);
  PRNU = [each_channel(slopes, at, @std2)' each_channel(slopes, at, @mean2)'];
  put(list, out, [folder 'PRNU_final_cropped_image.csv'], PRNU);
  put(list, out, [folder 'PRNU_1288_cropped_image.csv'], 100 * (PRNU(:, 1) ./ PRNU(:, 2)));
  put(list, out, [folder 'DSNU_final_cropped_image.csv'], ...
      [each_channel(intercepts, at, @std2)' each_channel(intercepts, at, @mean2)']);
  p_prnu = zeros(16, 4);
  p_pxr = zeros(16, 4);
  p_dsnu = zeros(16, 4);
  p_dv = zeros(16, 4);
  l = 1;
  for j = 1:4
    for i = 1:4
      patch = zeros(length(exposures), edge + 1, edge + 1);
      for e = 1:length(exposures)
        patch(e, :, :) = imcrop(squeeze(stack(e, :, :)), [r_coord(i) c_coord(j) edge edge]);
      end
      [p_slopes, p_intercepts] = per_pixel(exposures, patch, l == 2);
      put_maps(list, out, folder, sprintf('patch_%d', l), p_slopes, p_intercepts, at);
      p_prnu(l, :) = each_channel(p_slopes, at, @std2);
      p_pxr(l, :) = each_channel(p_slopes, at, @mean2);
      p_dsnu(l, :) = each_channel(p_intercepts, at, @std2);
      p_dv(l, :) = each_channel(p_intercepts, at, @mean2);
      l = l + 1;
    end
  end
  put(list, out, [folder 'PRNU_final_16patches.csv'], p_prnu);
  put(list, out, [folder 'DSNU_final_16patches.csv'], p_dsnu);
  put(list, out, [folder 'DarkV_final_patches.csv'], p_dv);
  put(list, out, [folder 'PRNU1288_patches.csv'], 100 * (p_prnu ./ p_pxr));
  put(list, out, [folder 'PX_Response_final_patches.csv'], p_pxr);
end

% ---- DSNU by standard deviation against exposure, at the lowest ISO
x = [];
y = [];
for e = 1:length(flat_exposures)
  for j = 1:flat_frames
    img = double(flats{1, e, j}) ./ 65535;
    y = [y; std2(img ./ map)];
    x = [x; flat_exposures(e)];
  end
end
coeff = polyfit(x, y, 1);
put(list, out, 'std_line', [coeff (coeff(2) * 0.459) / 1023]);
put(list, out, 'std_of_frames', y);

% ---- dark current
dark = zeros(0, 5);
for iso = 1:length(isos)
  x = [];
  y = zeros(0, 4);
  for e = 1:length(dark_exposures)
    for j = 1:dark_frames
      img = double(next_frame(fid, rows, columns));
      if iso == 1 || j == 1
        x = [x; dark_exposures(e)];
        y = [y; each_channel(img, at, @mean2)];
      end
    end
  end
  for channel = 1:4
    coeff = polyfit(x, y(:, channel), 1);
    dark(end + 1, :) = [isos(iso) channel coeff (coeff(1) * 0.459) / 1023];
  end
end
put(list, out, 'dark_current.csv', dark);

% ---- read noise
read_noise = zeros(0, 5);
for iso = 1:length(isos)
  repeats = zeros(rows, columns, 5);
  for j = 1:bias_frames
    img = double(next_frame(fid, rows, columns));
    if j <= 5
      repeats(:, :, j) = img;
    end
  end
  average = mean(repeats, 3);
  for j = 1:5
    flow2 = std(reshape(average - repeats(:, :, j), rows * columns, 1));
    pairs = [];
    for i = [1:j - 1, j + 1:5]
      pairs(end + 1) = var(reshape(repeats(:, :, i) - repeats(:, :, j), rows * columns, 1)) / 2;
    end
    read_noise(end + 1, :) = [isos(iso) j sqrt(mean(pairs)) flow2 flow2 * (0.4591 / 2^10)];
  end
end
put(list, out, 'read_noise.csv', read_noise);
fclose(list);
fclose(out);
