# SPDX-License-Identifier: Apache-2.0
# ROCSAFE without a compiler in the image that flies. Build it in the folder of the checkout:
#   docker build -t rocsafe . && docker run --rm -v "$PWD/runs:/runs" rocsafe
# NOT TRIED: the machine of the project's tests has no Docker. The same steps, without the
# container, are tried by test/setup/test_distribution.py and told in docs/wheels.md.
FROM debian:12-slim AS wheels
RUN apt-get update && apt-get install -y --no-install-recommends \
    bash ca-certificates cmake g++ git make python3 python3-dev python3-venv
COPY . /rocsafe
WORKDIR /rocsafe
RUN make wheels

FROM debian:12-slim
RUN apt-get update && apt-get install -y --no-install-recommends \
    ca-certificates libegl1 libgl1 libgl1-mesa-dri python3 python3-venv \
    && rm -rf /var/lib/apt/lists/*
RUN --mount=type=bind,from=wheels,source=/rocsafe/dist,target=/dist \
    python3 -m venv /opt/rocsafe && /opt/rocsafe/bin/pip install --no-cache-dir -r /dist/install.txt
RUN useradd --create-home rocsafe && mkdir /runs && chown rocsafe /runs
ENV PATH=/opt/rocsafe/bin:$PATH
USER rocsafe
WORKDIR /
CMD ["rocsafe", "run", "/opt/rocsafe/share/rocsafe/config/scenarios/derailment.yaml"]
